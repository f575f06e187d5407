//! Addresses of object stores: a bucket and the folder in it.

use std::fmt;
use std::str::FromStr;

/// Address of the object store of large files, `s3://BUCKET` or `s3://BUCKET/FOLDER`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlobAddress {
    bucket: String,
    /// Names of the folders, with `/` between them; empty for the whole bucket.
    folder: String,
}

impl BlobAddress {
    /// Name of the bucket.
    pub(crate) fn bucket(&self) -> &str {
        &self.bucket
    }

    /// Returns the path of an object in the bucket.
    pub(crate) fn path(&self, name: &str) -> String {
        match self.folder.as_str() {
            "" => name.to_owned(),
            folder => format!("{folder}/{name}"),
        }
    }

    /// Returns the name of the object at a path; `None` if it is in another folder.
    pub(crate) fn name<'p>(&self, path: &'p str) -> Option<&'p str> {
        match self.folder.as_str() {
            "" => Some(path),
            folder => path.strip_prefix(folder)?.strip_prefix('/'),
        }
    }
}

impl FromStr for BlobAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let invalid = || {
            "the address of an object store must be s3://BUCKET or s3://BUCKET/FOLDER, of letters, \
             digits and the signs - _ ."
                .to_owned()
        };
        let rest = text.strip_prefix("s3://").ok_or_else(invalid)?;
        let rest = rest.strip_suffix('/').unwrap_or(rest);
        let is_plain = |name: &str| {
            let mut bytes = name.bytes();
            bytes.all(|byte| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte))
                && !matches!(name, "" | "." | "..")
        };
        if !rest.split('/').all(is_plain) {
            return Err(invalid());
        }
        let (bucket, folder) = rest.split_once('/').unwrap_or((rest, ""));
        Ok(Self { bucket: bucket.to_owned(), folder: folder.to_owned() })
    }
}

impl fmt::Display for BlobAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slash = if self.folder.is_empty() { "" } else { "/" };
        write!(f, "s3://{}{slash}{}", self.bucket, self.folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn address_has_a_bucket_and_a_folder() {
        for (text, shown, path) in [
            ("s3://studio", "s3://studio", "targets/1"),
            ("s3://studio/", "s3://studio", "targets/1"),
            (
                "s3://studio.example/brood/a_1",
                "s3://studio.example/brood/a_1",
                "brood/a_1/targets/1",
            ),
        ] {
            let address: BlobAddress = text.parse().unwrap();
            assert_eq!(
                (address.to_string(), address.path("targets/1")),
                (shown.into(), path.into())
            );
            assert_eq!(address.name(path), Some("targets/1"));
        }
        let address: BlobAddress = "s3://studio/brood".parse().unwrap();
        assert_eq!((address.name("brood2/x"), address.name("other/x")), (None, None));
    }

    #[test]
    fn other_addresses_are_refused() {
        for text in
            ["", "studio", "s3://", "s3:///a", "s3://a//b", "s3://a/../b", "s3://a?b", "https://a"]
        {
            assert!(text.parse::<BlobAddress>().is_err(), "{text}");
        }
    }
}
