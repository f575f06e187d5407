//! Compares the canonical functions with `libm` in f64: `functions [--stride N] [--only sin,ex2]`.
//!
//! Stride 1 tests every f32 in a function's domain. A larger stride tests every N-th, and all
//! neighbours of critical arguments: clamps, powers of two, zeros and the borders of range
//! reductions. Prints the largest errors with their arguments and fails if one exceeds its bound.
//! Beyond a clamp the result must be the one at the clamp, and symmetric functions must be
//! symmetric, both to the bit.

use std::io::Write as _;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use brood_genome::{Arithmetic, RANGE};

/// Number of arguments of a task.
const CHUNK: u64 = 1 << 18;
/// Number of neighbours tested on either side of a critical argument.
const NEIGHBOURS: u32 = 64;
/// Sines below this magnitude have an absolute bound: near a zero, units in the last place are too
/// small.
const SMALL: f64 = 1.0 / 1024.0;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (stride, subjects) = match read(&arguments) {
        Ok(read) => read,
        Err(message) => {
            eprintln!("{message}\nusage: functions [--stride N] [--only NAME,NAME]");
            return ExitCode::from(2);
        }
    };
    println!(
        "function   arguments  largest error in ulp           absolute                       share of the bound"
    );
    let started = Instant::now();
    let total: u64 = subjects.iter().map(|subject| subject.cost(stride)).sum();
    let mut done = 0;
    let mut broken = 0;
    for subject in &subjects {
        let progress = Progress { started, before: done, total, seen: AtomicU64::new(0) };
        let worst = subject.check(stride, &progress);
        done += subject.cost(stride);
        println!("{}", worst.line(subject));
        if let Some(message) = &worst.broken {
            eprintln!("{}: {} broken, one of them: {message}", subject.name, worst.violations);
            broken += worst.violations;
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    println!("stride {stride}, {broken} broken, {seconds:.1} s");
    if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn read(arguments: &[String]) -> Result<(u32, Vec<Subject>), String> {
    let mut stride = 1;
    let mut subjects = subjects();
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let value = words.next().ok_or_else(|| format!("{word} needs a value"))?;
        match word.as_str() {
            "--stride" => {
                stride = value.parse().ok().filter(|n| *n > 0).ok_or("a stride is at least 1")?;
            }
            "--only" => {
                let names: Vec<&str> = value.split(',').collect();
                if let Some(name) = names.iter().find(|n| subjects.iter().all(|s| s.name != **n)) {
                    return Err(format!("no function {name}"));
                }
                subjects.retain(|subject| names.contains(&subject.name));
            }
            _ => return Err(format!("unknown option {word}")),
        }
    }
    Ok((stride, subjects))
}

/// A function with its domain and its error bound.
struct Subject {
    name: &'static str,
    canonical: fn(f32) -> f32,
    reference: fn(f64) -> f64,
    symmetry: Symmetry,
    /// Range that arguments are clamped to; `None` if only the machine's own range occurs.
    clamp: Option<(f32, f32)>,
    bound: Bound,
    /// Range of all results.
    results: (f32, f32),
    /// Arguments at which an implementation may switch between cases.
    critical: fn() -> Vec<f32>,
}

#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    None,
    Even,
    Odd,
}

/// Error bound from the docs of `brood_genome`'s functions.
#[derive(Clone, Copy)]
enum Bound {
    /// In units in the last place.
    Ulp(f64),
    /// In units in the last place where the result is not small, otherwise absolute.
    UlpUnlessSmall { ulp: f64, absolute: f64 },
    /// An absolute error plus a share of the result.
    Absolute { absolute: f64, relative: f64 },
}

fn subjects() -> Vec<Subject> {
    let angle = Bound::UlpUnlessSmall { ulp: 2.0, absolute: 1.2e-7 };
    let subject = |name, canonical, reference, bound| Subject {
        name,
        canonical,
        reference,
        symmetry: Symmetry::None,
        clamp: None,
        bound,
        results: (-RANGE, RANGE),
        critical: powers_of_two,
    };
    vec![
        Subject {
            symmetry: Symmetry::Odd,
            clamp: Some((-1024.0, 1024.0)),
            results: (-1.000_000_2, 1.000_000_2),
            critical: eighths_of_a_turn,
            ..subject("sin", f32::sine, f64::sine, angle)
        },
        Subject {
            symmetry: Symmetry::Even,
            clamp: Some((-1024.0, 1024.0)),
            results: (-1.000_000_2, 1.000_000_2),
            critical: eighths_of_a_turn,
            ..subject("cos", f32::cosine, f64::cosine, angle)
        },
        Subject {
            clamp: Some((-24.0, 16.0)),
            results: (1.0 / 16_777_216.0, RANGE),
            critical: halves,
            ..subject("ex2", f32::ex2, f64::ex2, Bound::Ulp(2.0))
        },
        Subject {
            symmetry: Symmetry::Even,
            results: (-24.0, 32.0),
            ..subject(
                "lg2",
                f32::lg2,
                f64::lg2,
                Bound::Absolute { absolute: 2.5e-6, relative: 0.0 },
            )
        },
        Subject {
            symmetry: Symmetry::Odd,
            results: (-2048.01, 2048.01),
            ..subject("rcp", f32::rcp, f64::rcp, Bound::Ulp(4.0))
        },
        Subject {
            symmetry: Symmetry::Even,
            results: (1.0 / 65536.0, 4096.01),
            ..subject("rsq", f32::rsq, f64::rsq, Bound::Ulp(4.0))
        },
        Subject {
            results: (0.0, RANGE),
            critical: halves,
            ..subject(
                "spl",
                f32::spl,
                f64::spl,
                Bound::Absolute { absolute: 1e-6, relative: 1.2e-7 },
            )
        },
    ]
}

/// Multiples of pi/4: zeros, extremes, and borders between quadrants of the range reduction.
fn eighths_of_a_turn() -> Vec<f32> {
    let mut found: Vec<f32> =
        (0..=1304u16).map(|k| f32::from(k) * std::f32::consts::FRAC_PI_4).collect();
    // Arguments at which a range reduction that rounds twice has its largest errors.
    found.extend([581.210_27, 925.167_8, 1024.0]);
    found.extend(powers_of_two());
    found
}

/// Multiples of 1/2: integer results, and borders of the range reduction.
fn halves() -> Vec<f32> {
    let mut found: Vec<f32> = (0..=50u16).map(|k| f32::from(k) / 2.0).collect();
    found.extend(powers_of_two());
    found
}

/// Powers of two and of their square root, 0 and the range.
fn powers_of_two() -> Vec<f32> {
    let powers = (1..=142u32).map(|exponent| f32::from_bits(exponent << 23));
    let mut found: Vec<f32> = powers.flat_map(|p| [p, p * std::f32::consts::SQRT_2]).collect();
    found.extend([0.0, RANGE]);
    found
}

/// Bits of the largest finite f32.
const LARGEST: u32 = 0x7f7f_ffff;

impl Subject {
    /// Bits of the largest magnitude of an argument.
    fn last(&self) -> u32 {
        if self.clamp.is_some() { LARGEST } else { RANGE.to_bits() }
    }

    /// Approximate number of evaluations of the reference, which dominate the time.
    fn cost(&self, stride: u32) -> u64 {
        let signs = if self.symmetry == Symmetry::None { 2 } else { 1 };
        let high = self.clamp.map_or(RANGE, |(low, high)| high.max(-low)).to_bits();
        signs * u64::from(high / stride)
    }

    /// Tests every `stride`-th argument of either sign, then the neighbours of critical arguments.
    fn check(&self, stride: u32, progress: &Progress) -> Worst {
        let count = u64::from(self.last() / stride) + 1;
        let next = AtomicU64::new(0);
        let sweep = || {
            let mut worst = Worst::default();
            loop {
                let first = next.fetch_add(1, Ordering::Relaxed) * CHUNK;
                let indices = first..(first + CHUNK).min(count);
                if indices.is_empty() {
                    return worst;
                }
                progress.add(self, (indices.end - indices.start) * u64::from(stride), stride);
                for index in indices {
                    let bits = u32::try_from(index * u64::from(stride)).expect("below 2^31");
                    self.look(bits, &mut worst);
                }
            }
        };
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let mut worst = std::thread::scope(|scope| {
            let sweeps: Vec<_> = (0..threads).map(|_| scope.spawn(sweep)).collect();
            let found = sweeps.into_iter().map(|sweep| sweep.join().expect("no sweep panics"));
            found.fold(Worst::default(), Worst::join)
        });
        if stride > 1 {
            for middle in (self.critical)() {
                let first = middle.to_bits().saturating_sub(NEIGHBOURS);
                let last = (middle.to_bits() + NEIGHBOURS).min(self.last());
                (first..=last).for_each(|bits| self.look(bits, &mut worst));
            }
        }
        worst
    }

    /// Tests both arguments of this magnitude.
    fn look(&self, bits: u32, worst: &mut Worst) {
        let x = f32::from_bits(bits);
        let positive = self.one(x, worst);
        let mirrored = match self.symmetry {
            Symmetry::None => {
                self.one(-x, worst);
                return;
            }
            Symmetry::Even => positive,
            Symmetry::Odd => -positive,
        };
        let negative = (self.canonical)(-x);
        worst.arguments += 1;
        // Zeros may differ in sign: symmetry means equal values.
        if negative.to_bits() != mirrored.to_bits() && !(negative == 0.0 && mirrored == 0.0) {
            worst.violate(|| {
                format!("{} at {x:e} is {positive:e}, at {:e} {negative:e}", self.name, -x)
            });
        }
    }

    fn one(&self, x: f32, worst: &mut Worst) -> f32 {
        let got = (self.canonical)(x);
        worst.arguments += 1;
        let beyond = self.clamp.map(|(low, high)| if x < low { low } else { high });
        if let Some(clamp) =
            beyond.filter(|clamp| x.abs() > clamp.abs() && (x < 0.0) == (*clamp < 0.0))
        {
            let expected = (self.canonical)(clamp);
            if got.to_bits() != expected.to_bits() {
                worst.violate(|| {
                    format!("{x:e}: {got:e} is not {expected:e}, the result at the clamp")
                });
            }
            return got;
        }
        let exact = (self.reference)(f64::from(x));
        worst.see(self, x, got, exact);
        got
    }
}

impl Bound {
    /// Error as a share of the bound; infinite for NaN.
    fn share(self, error: f64, error_ulp: f64, exact: f64) -> f64 {
        let share = match self {
            Self::Ulp(ulp) => error_ulp / ulp,
            Self::UlpUnlessSmall { ulp, .. } if exact.abs() >= SMALL => error_ulp / ulp,
            Self::UlpUnlessSmall { absolute, .. } => error / absolute,
            Self::Absolute { absolute, relative } => error / (absolute + relative * exact.abs()),
        };
        if share.is_nan() { f64::INFINITY } else { share }
    }
}

/// Largest value and its argument.
#[derive(Clone, Copy, Default)]
struct Peak {
    value: f64,
    at: f32,
}

impl Peak {
    fn see(&mut self, value: f64, at: f32) {
        if value > self.value {
            *self = Self { value, at };
        }
    }

    /// Returns the larger value, or the one with the smaller argument if equal, so that the result
    /// does not depend on the order of the threads.
    fn join(self, other: Self) -> Self {
        let order = self.value.total_cmp(&other.value).then(other.at.total_cmp(&self.at));
        if order.is_lt() { other } else { self }
    }
}

/// Largest errors over some of the arguments.
#[derive(Default)]
struct Worst {
    arguments: u64,
    /// Over results that are not small, or over all if the bound is in units in the last place.
    ulp: Peak,
    absolute: Peak,
    share: Peak,
    violations: u64,
    broken: Option<String>,
}

impl Worst {
    fn see(&mut self, subject: &Subject, x: f32, got: f32, exact: f64) {
        let error = (f64::from(got) - exact).abs();
        let error_ulp = error * per_ulp(exact);
        let share = subject.bound.share(error, error_ulp, exact);
        if exact.abs() >= SMALL || matches!(subject.bound, Bound::Ulp(_)) {
            self.ulp.see(error_ulp, x);
        }
        self.absolute.see(error, x);
        self.share.see(share, x);
        let (low, high) = subject.results;
        let whole = subject.name == "ex2" && x == x.trunc();
        if share > 1.0 || !(low..=high).contains(&got) || (whole && f64::from(got) != exact) {
            self.violate(|| format!("{} at {x:e} is {got:e}, exactly {exact:e}", subject.name));
        }
    }

    fn violate(&mut self, message: impl FnOnce() -> String) {
        self.violations += 1;
        if self.broken.is_none() {
            self.broken = Some(message());
        }
    }

    fn join(self, other: Self) -> Self {
        Self {
            arguments: self.arguments + other.arguments,
            ulp: self.ulp.join(other.ulp),
            absolute: self.absolute.join(other.absolute),
            share: self.share.join(other.share),
            violations: self.violations + other.violations,
            broken: self.broken.or(other.broken),
        }
    }

    fn line(&self, subject: &Subject) -> String {
        let peak = |peak: &Peak| format!("{:.4e} at {:<16e}", peak.value, peak.at);
        format!(
            "{:<8} {:>11}  {}  {}  {:5.1} %",
            subject.name,
            self.arguments,
            peak(&self.ulp),
            peak(&self.absolute),
            100.0 * self.share.value,
        )
    }
}

/// Inverse of the unit in the last place of f32 near `exact`: 2^(23 - exponent); subnormal numbers
/// count as the smallest normal one.
fn per_ulp(exact: f64) -> f64 {
    let exponent = ((exact.to_bits() >> 52) & 0x7ff).max(1023 - 126);
    f64::from_bits((23 + 2 * 1023 - exponent) << 52)
}

/// Prints progress to stderr, at most 20 times per function.
struct Progress {
    started: Instant,
    before: u64,
    total: u64,
    seen: AtomicU64,
}

impl Progress {
    fn add(&self, subject: &Subject, bits: u64, stride: u32) {
        let before = self.seen.fetch_add(bits, Ordering::Relaxed);
        let last = u64::from(subject.last()) + 1;
        let part = |bits: u64| bits.min(last) * 20 / last;
        if part(before) == part(before + bits) {
            return;
        }
        let share_of_subject = (before + bits).min(last) as f64 / last as f64;
        let done = self.before as f64 + share_of_subject * subject.cost(stride) as f64;
        let (share, seconds) = (done / self.total as f64, self.started.elapsed().as_secs_f64());
        let left = seconds * (1.0 - share) / share;
        let line = format!("{}: {:.0} %, about {left:.0} s left", subject.name, 100.0 * share);
        // A closed stderr must not stop the run.
        let _ = writeln!(std::io::stderr(), "{line}");
    }
}
