//! A full disk: writes are refused, reads go on, the server stops and starts, and nothing that was
//! acknowledged is lost.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use brood_tests::{ServerOptions, TestLineage, TestServer};
use serde_json::json;
use tempfile::TempDir;

/// Small file system in memory; needs the right to mount.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn mount(at: &Path) -> Option<Self> {
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", "size=8m,mode=0777", "none"]).arg(at);
        let mounted = mount.output().is_ok_and(|output| output.status.success());
        mounted.then(|| Self(at.to_owned()))
    }

    /// Uses up all space.
    fn fill(&self) {
        let mut ballast = File::create(self.0.join("ballast")).unwrap();
        for size in [1 << 16, 1 << 12, 1] {
            while ballast.write_all(&vec![1; size]).is_ok() {}
        }
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg("-l").arg(&self.0).status();
        assert!(unmounted.is_ok_and(|status| status.success()), "the disk of a test stays mounted");
        let _ = std::fs::remove_dir(&self.0);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn full_disk_refuses_writes_and_loses_nothing() {
    let folder = TempDir::new().unwrap();
    let Some(disk) = SmallDisk::mount(folder.path()) else {
        println!("fault: full disk: skipped, file systems cannot be mounted here");
        return;
    };
    let mut server = TestServer::start_on(ServerOptions::default(), folder);
    let (path, mut acknowledged) = {
        let lineage = TestLineage::new(&server).await;
        (lineage.path("/generations"), vec![lineage.random(1).await])
    };
    disk.fill();
    let mut refused = 0;
    for seed in 2..60 {
        let answer = server.post(&path, &json!({"count": 20, "seed": seed})).await;
        match answer.status {
            201 => acknowledged.push(answer.json()),
            507 => refused += 1,
            other => panic!("{other}: {}", answer.text()),
        }
    }
    assert!(refused > 0, "the disk is not full");
    let listed = server.get(&path).await.expect(200).json();
    assert_eq!(listed["items"].as_array().unwrap().len(), acknowledged.len().min(50));
    assert!(server.metric("brood_refused_writes_total").await >= refused);
    assert_eq!(server.terminate(), 0, "{}", server.log());

    server.restart();
    let listed = server.get(&path).await.expect(200).json();
    assert_eq!(listed["items"].as_array().unwrap().len(), acknowledged.len().min(50));
    std::fs::remove_file(server.data().join("ballast")).unwrap();
    server.post(&path, &json!({"count": 4, "seed": 99})).await.expect(201);
    println!("fault: full disk: {} acknowledged, {refused} refused, 0 lost", acknowledged.len());
    drop(server);
}
