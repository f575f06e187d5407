//! What keeps a driver's compiler from contracting and reassociating, and the ladder of such means that is climbed when
//! an adapter is opened.

use crate::GpuError;
use crate::probe::Finding;

/// A means against contraction, the plainest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Guard {
    /// None: the code says what it means and the driver may keep to it.
    Plain,
    /// Every intermediate result passes an exclusive or with a zero that the compiler does not know.
    Barrier,
    /// Every sum and product carries SPIR-V's `NoContraction`, which a driver has to obey. Needs Vulkan.
    NoContraction,
}

impl Guard {
    /// The ladder from below.
    pub const ALL: [Self; 3] = [Self::Plain, Self::Barrier, Self::NoContraction];

    /// The name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain code",
            Self::Barrier => "code with barriers",
            Self::NoContraction => "code marked NoContraction",
        }
    }
}

/// What the probe found with one guard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rung {
    /// The guard.
    pub guard: Guard,
    /// Whether every bit was right, subnormal results aside.
    pub exact: bool,
    /// What was compared, and the first difference.
    pub detail: String,
}

/// The guards that were tried, with what was found, and those that are exact.
#[derive(Debug, Clone)]
pub(crate) struct Ladder {
    pub rungs: Vec<(Guard, Finding)>,
}

impl Ladder {
    /// Probes guard after guard. Where the first is exact nothing more is asked; otherwise all are tried, so that the
    /// cheapest exact one can be taken and the report says what each of them did.
    pub(crate) fn climb(
        guards: &[Guard],
        mut probe: impl FnMut(Guard) -> Result<Finding, GpuError>,
    ) -> Result<Self, GpuError> {
        let mut rungs: Vec<(Guard, Finding)> = Vec::new();
        for guard in guards {
            let finding = match probe(*guard) {
                // A driver that refuses marked code may still run the other kinds.
                Err(GpuError::Rejected(reason)) if !rungs.is_empty() => {
                    Finding { exact: false, flushes_subnormals: false, detail: reason }
                }
                found => found?,
            };
            let is_enough = rungs.is_empty() && finding.exact;
            rungs.push((*guard, finding));
            if is_enough {
                break;
            }
        }
        Ok(Self { rungs })
    }

    /// The exact guards from below.
    pub(crate) fn exact(&self) -> Vec<Guard> {
        self.rungs.iter().filter(|(_, found)| found.exact).map(|(guard, _)| *guard).collect()
    }

    /// What was found with one guard.
    pub(crate) fn finding(&self, guard: Guard) -> Option<&Finding> {
        self.rungs.iter().find(|(tried, _)| *tried == guard).map(|(_, finding)| finding)
    }

    /// For a report.
    pub(crate) fn report(&self) -> Vec<Rung> {
        let rung = |(guard, found): &(Guard, Finding)| Rung {
            guard: *guard,
            exact: found.exact,
            detail: found.detail.clone(),
        };
        self.rungs.iter().map(rung).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(exact: bool) -> Finding {
        Finding { exact, flushes_subnormals: false, detail: String::new() }
    }

    #[test]
    fn ladder_stops_on_the_first_rung_when_it_is_exact() {
        let ladder = Ladder::climb(&Guard::ALL, |_| Ok(finding(true))).unwrap();
        assert_eq!((ladder.rungs.len(), ladder.exact()), (1, vec![Guard::Plain]));
    }

    #[test]
    fn ladder_is_climbed_to_the_end_when_plain_code_is_not_exact() {
        for exact in [vec![], vec![Guard::Barrier], vec![Guard::NoContraction]] {
            let ladder = Ladder::climb(&Guard::ALL, |g| Ok(finding(exact.contains(&g)))).unwrap();
            assert_eq!((ladder.rungs.len(), ladder.exact()), (3, exact));
        }
    }

    #[test]
    fn ladder_goes_on_when_marked_code_is_refused_but_not_when_the_device_is_lost() {
        let mut refused = false;
        let ladder = Ladder::climb(&Guard::ALL, |guard| match guard {
            Guard::Plain | Guard::Barrier => Ok(finding(guard == Guard::Barrier)),
            Guard::NoContraction => {
                refused = true;
                Err(GpuError::Rejected("no".into()))
            }
        });
        assert_eq!(ladder.unwrap().exact(), [Guard::Barrier]);
        assert!(refused);
        let lost = Ladder::climb(&Guard::ALL, |_| Err(GpuError::Lost("gone".into())));
        assert_eq!(lost.unwrap_err(), GpuError::Lost("gone".into()));
    }
}
