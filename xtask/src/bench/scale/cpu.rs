//! CPU time of processes, from `/proc`.

use anyhow::{Context, Result};

/// Ticks of the clock of `/proc` in a second, on every common processor.
const TICKS_PER_S: f64 = 100.0;
/// Fields of `/proc/PID/stat` after the name of the program: process that started it, own time in
/// user and kernel mode, the same of children that have ended.
const PARENT: usize = 1;
const OWN: [usize; 2] = [11, 12];
const ENDED: [usize; 2] = [13, 14];

/// CPU time of a process in seconds, without children.
pub fn own(process: u32) -> Result<f64> {
    sum(&read(&process.to_string())?, &OWN)
}

/// CPU time in seconds of the children of this program that have ended.
pub fn of_ended_children() -> Result<f64> {
    sum(&read("self")?, &ENDED)
}

/// CPU time in seconds of a process and of its children, also of those that have ended.
pub fn with_children(process: u32) -> Result<f64> {
    let stat = read(&process.to_string())?;
    let mut total = sum(&stat, &OWN)? + sum(&stat, &ENDED)?;
    for entry in std::fs::read_dir("/proc").context("list processes")?.filter_map(Result::ok) {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.bytes().all(|byte| byte.is_ascii_digit()) {
            continue;
        }
        // Processes may end meanwhile.
        let Ok(stat) = read(&name) else { continue };
        if stat.get(PARENT).is_some_and(|parent| *parent == process.to_string()) {
            total += sum(&stat, &OWN)?;
        }
    }
    Ok(total)
}

/// Fields after the name, which may have spaces and brackets.
fn read(process: &str) -> Result<Vec<String>> {
    let file = format!("/proc/{process}/stat");
    let text = std::fs::read_to_string(&file).with_context(|| format!("read {file}"))?;
    let (_, fields) = text.rsplit_once(')').with_context(|| format!("find a name in {file}"))?;
    Ok(fields.split_whitespace().map(str::to_owned).collect())
}

fn sum(stat: &[String], fields: &[usize]) -> Result<f64> {
    let ticks: Option<Vec<f64>> =
        fields.iter().map(|field| stat.get(*field)?.parse().ok()).collect();
    let ticks = ticks.context("find the CPU time of a process")?;
    Ok(ticks.into_iter().sum::<f64>() / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    use super::{of_ended_children, own, with_children};

    #[cfg(target_os = "linux")]
    #[test]
    fn time_of_this_process_is_counted_with_its_children() {
        let process = std::process::id();
        let before = own(process).unwrap();
        let all = with_children(process).unwrap();
        assert!(all >= before && of_ended_children().unwrap() >= 0.0, "{all} of {before}");
    }
}
