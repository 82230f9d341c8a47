//! What tests of the command share.

pub mod build;
pub mod command;

use std::process::Output;

/// Holds an exit status and words of what was told; nothing may have panicked.
pub fn check(output: &Output, status: i32, words: &[&str]) {
    let told = String::from_utf8_lossy(&output.stderr).into_owned() + &*String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(status), "{told}");
    for word in words {
        assert!(told.contains(word), "`{word}` is missing from: {told}");
    }
    assert!(!told.contains("panicked"), "{told}");
}
