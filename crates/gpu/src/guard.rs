//! Guards: means that keep the compiler of a driver from contracting (rounding a product and a sum
//! once, as a fused multiply-add) and from reassociating sums, both of which change bits. When an
//! adapter is opened, a search finds the guards that work.

use crate::GpuError;

/// A means against contraction, the plainest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Guard {
    /// No guard: plain code, which the driver may or may not compile as written.
    Plain,
    /// Every intermediate result passes an exclusive or with a zero that is unknown to the
    /// compiler.
    Barrier,
    /// Every sum and product carries the decoration `NoContraction` of SPIR-V, which a driver must
    /// obey, and subnormal numbers are kept if the device can. Requires Vulkan.
    NoContraction,
}

impl Guard {
    /// All guards, the plainest first.
    pub const ALL: [Self; 3] = [Self::Plain, Self::Barrier, Self::NoContraction];

    /// Returns the name used in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain code",
            Self::Barrier => "code with barriers",
            Self::NoContraction => "code marked NoContraction",
        }
    }
}

/// Result of a probe, made by `probe.rs`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Finding {
    /// True if all bits are equal.
    pub exact: bool,
    /// True if the device returned zero for a subnormal number.
    pub flushes_subnormals: bool,
    /// For people: number of values compared, and the first difference.
    pub detail: String,
}

/// Result of the probe with one guard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GuardReport {
    /// The guard.
    pub guard: Guard,
    /// True if every bit was right.
    pub exact: bool,
    /// Number of values compared, and the first difference.
    pub detail: String,
}

/// Results of all guards that were probed.
#[derive(Debug, Clone)]
pub(crate) struct GuardSearch {
    pub probed: Vec<(Guard, Finding)>,
}

impl GuardSearch {
    /// Probes guards in order. If the first is exact, the others are not probed; otherwise all are,
    /// so that the fastest exact one can be chosen and the report covers each of them.
    pub(crate) fn run(
        guards: &[Guard],
        mut probe: impl FnMut(Guard) -> Result<Finding, GpuError>,
    ) -> Result<Self, GpuError> {
        let mut probed: Vec<(Guard, Finding)> = Vec::new();
        for guard in guards {
            let finding = match probe(*guard) {
                // A driver that rejects marked code may still run the other kinds.
                Err(GpuError::Rejected(reason)) if !probed.is_empty() => {
                    Finding { exact: false, flushes_subnormals: false, detail: reason }
                }
                found => found?,
            };
            let is_enough = probed.is_empty() && finding.exact;
            probed.push((*guard, finding));
            if is_enough {
                break;
            }
        }
        Ok(Self { probed })
    }

    /// Returns the exact guards, the plainest first.
    pub(crate) fn exact(&self) -> Vec<Guard> {
        self.probed.iter().filter(|(_, found)| found.exact).map(|(guard, _)| *guard).collect()
    }

    /// Returns the result of one guard.
    pub(crate) fn finding(&self, guard: Guard) -> Option<&Finding> {
        self.probed.iter().find(|(tried, _)| *tried == guard).map(|(_, finding)| finding)
    }

    /// Returns the results for a report.
    pub(crate) fn report(&self) -> Vec<GuardReport> {
        let report_of = |(guard, found): &(Guard, Finding)| GuardReport {
            guard: *guard,
            exact: found.exact,
            detail: found.detail.clone(),
        };
        self.probed.iter().map(report_of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(exact: bool) -> Finding {
        Finding { exact, flushes_subnormals: false, detail: String::new() }
    }

    #[test]
    fn search_stops_when_the_first_guard_is_exact() {
        let search = GuardSearch::run(&Guard::ALL, |_| Ok(finding(true))).unwrap();
        assert_eq!((search.probed.len(), search.exact()), (1, vec![Guard::Plain]));
    }

    #[test]
    fn all_guards_are_probed_when_plain_code_is_not_exact() {
        for exact in [vec![], vec![Guard::Barrier], vec![Guard::NoContraction]] {
            let search =
                GuardSearch::run(&Guard::ALL, |g| Ok(finding(exact.contains(&g)))).unwrap();
            assert_eq!((search.probed.len(), search.exact()), (3, exact));
        }
    }

    #[test]
    fn search_continues_when_marked_code_is_rejected_but_not_when_the_device_is_lost() {
        let mut rejected = false;
        let search = GuardSearch::run(&Guard::ALL, |guard| match guard {
            Guard::Plain | Guard::Barrier => Ok(finding(guard == Guard::Barrier)),
            Guard::NoContraction => {
                rejected = true;
                Err(GpuError::Rejected("no".into()))
            }
        });
        assert_eq!(search.unwrap().exact(), [Guard::Barrier]);
        assert!(rejected);
        let lost = GuardSearch::run(&Guard::ALL, |_| Err(GpuError::Lost("gone".into())));
        assert_eq!(lost.unwrap_err(), GpuError::Lost("gone".into()));
    }
}
