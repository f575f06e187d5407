//! Rules for migrations of PostgreSQL that are applied while servers run: they keep no table locked
//! for long, and servers of the earlier schema can write to the tables.

use crate::engine::postgres::MIGRATIONS;

/// Tables with few rows, which may be read or written as a whole.
const SMALL: [&str; 6] = ["closed", "export", "search", "target", "token", "unfinished_lineage"];

/// Returns why a migration must not be applied while servers run; `None` if it may be.
fn fault(sql: &str) -> Option<String> {
    let lines = sql.lines().map(|line| line.split("--").next().unwrap_or_default());
    let text = lines.collect::<Vec<_>>().join(" ");
    let statements: Vec<Vec<&str>> = text
        .split(';')
        .map(|statement| statement.split_whitespace().collect())
        .filter(|words: &Vec<&str>| !words.is_empty())
        .collect();
    let mut made = Vec::new();
    for words in &statements {
        let statement = words.join(" ");
        let is_short = |table: &str| SMALL.contains(&table) || made.contains(&table.to_owned());
        let reason = match words[..] {
            ["CREATE", "TABLE", table, ..] => {
                let reason = fault_of_references(&statement);
                made.push(table.to_owned());
                reason
            }
            ["CREATE", "INDEX", "CONCURRENTLY", "IF", "NOT", "EXISTS", ..]
            | ["DROP", "INDEX", "CONCURRENTLY", "IF", "EXISTS", ..] => {
                let is_alone = statements.len() == 1 && sql.starts_with("-- no-transaction\n");
                (!is_alone).then_some("needs a file of its own that begins with -- no-transaction")
            }
            ["CREATE", "INDEX", _, "ON", table, ..] => {
                (!is_short(table)).then_some("locks the table: use CONCURRENTLY IF NOT EXISTS")
            }
            ["ALTER", "TABLE", table, "ADD", "COLUMN", ..] => {
                fault_of_columns(&statement, is_short(table))
            }
            ["ALTER", "TABLE", _, "ALTER", "COLUMN", _, "SET", "STORAGE" | "DEFAULT", ..]
            | ["ALTER", "TABLE", _, "ALTER", "COLUMN", _, "DROP", "NOT", "NULL"] => None,
            ["INSERT", "INTO", table, ..] | ["UPDATE", table, ..] => {
                (!is_short(table)).then_some("locks rows of a large table")
            }
            _ => Some("is not known to leave earlier servers alone"),
        };
        if let Some(reason) = reason {
            return Some(format!("{statement}: {reason}"));
        }
    }
    None
}

/// Servers of the earlier schema remove rows without those of the new table.
fn fault_of_references(statement: &str) -> Option<&'static str> {
    let is_free = |reference: &str| {
        let column = reference.split(',').next().unwrap_or_default();
        column.contains("ON DELETE CASCADE") || column.contains("ON DELETE SET NULL")
    };
    let all_free = statement.split(" REFERENCES ").skip(1).all(is_free);
    (!all_free).then_some("a reference needs ON DELETE CASCADE or SET NULL")
}

/// Servers of the earlier schema insert rows without the new columns.
fn fault_of_columns(statement: &str, is_short: bool) -> Option<&'static str> {
    for column in statement.split("ADD COLUMN ").skip(1) {
        let default = column.split_once(" DEFAULT ").map(|(_, default)| default);
        if column.contains(" NOT NULL") && default.is_none() {
            return Some("a column needs a default or must accept NULL");
        }
        let value = default.and_then(|default| default.split_whitespace().next());
        if value.is_some_and(|value| value.contains('(') || value.starts_with("CURRENT")) {
            return Some("a default must be a constant, or the table is written anew");
        }
        let checks = ["CHECK", "REFERENCES", "UNIQUE", "PRIMARY KEY", "GENERATED", "IDENTITY"];
        if !is_short && checks.iter().any(|word| column.contains(word)) {
            return Some("a constraint reads the whole table");
        }
    }
    None
}

#[test]
fn migrations_that_earlier_servers_outlive_keep_the_rules() {
    for step in MIGRATIONS.iter() {
        let sql = step.sql.as_str();
        if sql.contains("-- Servers of schema ") {
            let line = sql.lines().find(|line| line.starts_with("-- Servers of schema "));
            assert!(line.is_some_and(|line| line.ends_with(" or later run on these tables.")));
            assert_eq!(fault(sql), None, "migration {}", step.version);
        }
    }
}

#[test]
fn statements_that_stop_earlier_servers_are_found() {
    for sql in [
        "ALTER TABLE genome ADD COLUMN colour TEXT; -- Why.\nCREATE TABLE shade (id BIGINT);\n\
         CREATE INDEX shade_id ON shade (id);",
        "ALTER TABLE search ADD COLUMN island BIGINT NOT NULL DEFAULT 0 CHECK (island >= 0)",
        "-- no-transaction\nCREATE INDEX CONCURRENTLY IF NOT EXISTS g ON genome (layers);\n",
        "CREATE TABLE shade (id BYTEA REFERENCES search (id) ON DELETE CASCADE, of BIGINT)",
        "UPDATE search SET deaths = 0",
    ] {
        assert_eq!(fault(sql), None);
    }
    for sql in [
        "ALTER TABLE genome ADD COLUMN colour TEXT NOT NULL",
        "ALTER TABLE genome ADD COLUMN colour TEXT CHECK (colour <> '')",
        "ALTER TABLE genome ADD COLUMN born TIMESTAMPTZ DEFAULT now()",
        "ALTER TABLE genome DROP COLUMN layers",
        "ALTER TABLE genome RENAME COLUMN layers TO models",
        "ALTER TABLE genome ALTER COLUMN layers SET NOT NULL",
        "CREATE INDEX genome_layers ON genome (layers)",
        "CREATE INDEX CONCURRENTLY IF NOT EXISTS genome_layers ON genome (layers); SELECT 1",
        "CREATE TABLE shade (id BYTEA REFERENCES lineage (id), of BIGINT)",
        "UPDATE genome SET kept = FALSE",
        "DROP TABLE closed",
    ] {
        assert!(fault(sql).is_some(), "{sql}");
    }
}
