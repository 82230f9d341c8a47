//! `plat words`: the reference of the rule language.

use super::{Failure, Status, WordsArguments};
use script::reference::{Word, definitions, markdown, reference};

/// Prints the reference, or the words with something in their name.
pub fn run(arguments: &WordsArguments) -> Result<Status, Failure> {
    if arguments.markdown {
        print!("{}", markdown());
        return Ok(Status::Done);
    }
    if arguments.definitions {
        print!("{}", definitions());
        return Ok(Status::Done);
    }
    let wanted = arguments.name.as_deref().unwrap_or_default();
    let mut count = 0;
    for chapter in reference() {
        let words: Vec<&Word> = chapter.words.iter().filter(|word| word.name.contains(wanted)).collect();
        if words.is_empty() {
            continue;
        }
        count += words.len();
        println!("{}: {}", chapter.title.replace('`', ""), chapter.about.replace('`', ""));
        for word in words {
            println!(
                "  {}\n      {}\n      e.g. {}",
                word.forms.join("  or  "),
                word.about.replace('`', ""),
                word.example
            );
        }
        println!();
    }
    if count == 0 {
        let known: Vec<String> =
            reference().into_iter().flat_map(|chapter| chapter.words).map(|word| word.name).collect();
        let near = script::nearest(wanted, known.iter().map(String::as_str));
        let help = near.map_or("plat words lists all".to_owned(), |near| format!("did you mean `{near}`?"));
        return Err(Failure::new(Status::Usage, format!("no word has `{wanted}` in its name\n  hint: {help}")));
    }
    Ok(Status::Done)
}
