//! Random bytes of the operating system, for seeds, tokens and file names.

use std::io;

/// Number of random bytes in a token.
const TOKEN_BYTES: usize = 32;

/// Returns random bytes.
///
/// # Errors
/// [`io::Error`] if the system has none.
pub fn random_bytes<const N: usize>() -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes)?;
    Ok(bytes)
}

/// Returns a random token of 64 hexadecimal digits.
///
/// # Errors
/// As [`random_bytes`].
pub fn random_token() -> io::Result<String> {
    let secret: [u8; TOKEN_BYTES] = random_bytes()?;
    Ok(blake3::Hash::from_bytes(secret).to_hex().to_string())
}
