//! Tests of encrypted connections to PostgreSQL. They do nothing without `BROOD_TEST_DATABASE`, and
//! with a database without TLS.

use sqlx::{AssertSqlSafe, Connection, Executor, PgConnection, Row};

use super::*;

/// Server that accepts TLS at `localhost`, with a new role that has a schema.
pub(super) struct Encrypted {
    /// Address without parameters.
    pub(super) address: String,
    /// Port at `localhost`.
    pub(super) port: u16,
    /// Path of the server's certificate.
    certificate: String,
}

impl Encrypted {
    pub(super) async fn find() -> Option<Self> {
        let address = std::env::var("BROOD_TEST_DATABASE").ok()?;
        let mut conn = PgConnection::connect(&address).await.unwrap();
        let sql = "SELECT current_setting('ssl') AS ssl, current_setting('port') AS port,
            current_setting('data_directory') || '/' || current_setting('ssl_cert_file') AS file";
        let settings = conn.fetch_one(sql).await.unwrap();
        if settings.get::<&str, _>("ssl") != "on" {
            return None;
        }
        let name = format!("tls_{}", JobId::fresh().to_string().replace('-', "_"));
        let role = format!(
            "CREATE ROLE {name} LOGIN PASSWORD 'secret'; CREATE SCHEMA {name} AUTHORIZATION {name}"
        );
        conn.execute(AssertSqlSafe(role)).await.unwrap();
        let port: &str = settings.get("port");
        Some(Self {
            address: format!("postgres://{name}:secret@localhost:{port}/postgres"),
            port: port.parse().unwrap(),
            certificate: settings.get("file"),
        })
    }
}

#[tokio::test]
async fn connection_is_encrypted_if_the_certificate_is_trusted() {
    let Some(Encrypted { address, certificate, .. }) = Encrypted::find().await else { return };
    let data = tempfile::tempdir().unwrap();
    let connect = async |parameters: &str| {
        let address = format!("{address}?{parameters}").into();
        Store::connect(&address, data.path()).await
    };
    let store = connect(&format!("sslmode=verify-full&sslrootcert={certificate}")).await.unwrap();
    let sql = "SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()";
    let is_encrypted = query(sql).fetch_value::<bool>(&mut store.reader().await.unwrap()).await;
    assert!(is_encrypted.unwrap());
    store.close().await.unwrap();

    connect("sslmode=require").await.unwrap().close().await.unwrap();
    let refused = connect("sslmode=verify-full").await.unwrap_err().to_string();
    assert!(refused.starts_with("cannot reach the database: postgres://tls_"), "{refused}");
    assert!(refused.contains("certificate") && !refused.contains("secret"), "{refused}");
}
