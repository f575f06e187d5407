//! Gauges: values that are read when the metrics are.

/// Declares the gauges with their names and descriptions, so that none is without.
macro_rules! gauges {
    ($($gauge:ident => $name:literal, $text:literal;)*) => {
        /// Gauge of `/metrics`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum GaugeName {
            $(#[doc = $text] $gauge,)*
        }

        impl GaugeName {
            /// All gauges.
            pub const ALL: &'static [Self] = &[$(Self::$gauge),*];

            /// Name of the metric.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$gauge => $name,)*
                }
            }

            /// Description of the metric.
            pub const fn text(self) -> &'static str {
                match self {
                    $(Self::$gauge => $text,)*
                }
            }
        }
    };
}

gauges! {
    Rows => "brood_rows", "Rows of each table, estimated for large tables of PostgreSQL";
    Jobs => "brood_jobs", "Render jobs of this server that have not succeeded, by queue and state";
    OldestRenderWait => "brood_oldest_render_wait_seconds",
        "Age of the oldest render job that waits in a queue of this server, 0 if none waits";
    Searches => "brood_searches", "Searches of the database by state";
    Exports => "brood_exports", "Export jobs of the database by state";
    DeferredRequests => "brood_deferred_requests",
        "Running requests whose answers are deferred";
    Connections => "brood_connections", "Open connections";
    WorkerConnections => "brood_worker_connections", "Open connections of workers";
    LogBytes => "brood_log_bytes", "Size of the log of the SQLite database, 0 on PostgreSQL";
    Leases => "brood_leases", "Render jobs that are leased to workers";
    PicturesUnderWay => "brood_pictures_under_way", "Pictures that are awaited or being rendered";
    CacheMemoryBytes => "brood_cache_memory_bytes", "Size of the pictures in memory";
    CacheDiskBytes => "brood_cache_disk_bytes", "Size of the pictures on disk";
    CacheDiskPictures => "brood_cache_disk_pictures", "Number of pictures on disk";
}
