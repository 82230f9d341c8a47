//! Words for texts that Rhai would let grow before it measures them.

use rhai::{Engine, EvalAltResult, ImmutableString, Position};

type Told = Result<(), Box<EvalAltResult>>;

/// Registers `replace`, which refuses what grows beyond a limit before it is made: a text whose every letter becomes that
/// text is as long as its square.
pub(super) fn register(engine: &mut Engine, most: usize) {
    engine.register_fn("replace", move |text: &mut ImmutableString, old: ImmutableString, new: ImmutableString| {
        replace(text, &old, &new, most)
    });
    engine.register_fn("replace", move |text: &mut ImmutableString, old: char, new: ImmutableString| {
        replace(text, old.encode_utf8(&mut [0; 4]), &new, most)
    });
}

fn replace(text: &mut ImmutableString, old: &str, new: &str, most: usize) -> Told {
    let count = text.matches(old).count();
    let length = text.len() + count * new.len().saturating_sub(old.len());
    // A letter has at most four bytes; what is made is then measured in letters.
    if length > 4 * most {
        return Err(EvalAltResult::ErrorDataTooLarge("Length of string".into(), Position::NONE).into());
    }
    *text = text.replace(old, new).into();
    Ok(())
}
