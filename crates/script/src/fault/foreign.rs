//! What people write who come from other languages, and what it is called in this one.

/// What to write in the place of a word that other languages have.
pub(crate) fn instead(word: &str) -> Option<&'static str> {
    Some(match word {
        "rand" | "random" | "rnd" | "rand_int" | "rand_float" | "uniform" => {
            "chance(n) gives a number from 0 to below 1, always the same for the same n: tip.chance(1)"
        }
        "timestamp" | "time" | "now" | "today" | "clock" | "sleep" => {
            "rules know no clock: the same script gives the same city at any time"
        }
        "blob" => "there are numbers, texts, lists and maps",
        "null" | "nil" | "undefined" | "None" => "nothing is written `()`",
        "True" | "TRUE" => "write `true`",
        "False" | "FALSE" => "write `false`",
        "and" => "write `&&`",
        "or" => "write `||`",
        "not" => "write `!`",
        "elif" | "elsif" | "elseif" => "write `else if`",
        "def" | "function" | "func" | "fun" => "functions are written fn name(argument) { … }",
        "var" | "auto" | "int" | "float" | "double" => "variables begin with `let`: let x = 3;",
        "match" => "write switch x { 1 => …, _ => … }",
        "lambda" => "a closure is written |x| x + 1",
        "Math" | "math" => "the functions stand by themselves: sin(x), sqrt(x)",
        "console" | "printf" | "println" | "echo" | "log_info" => "print(…) writes into the report and on the terminal",
        "class" | "struct" | "enum" => "there are functions and maps: #{ turn: 3 }",
        "self" | "this" => "what a rule is asked about is its argument: tip, block, parcel, shape, segment",
        "foreach" => "write for x in list { … }",
        "new" => "values are made by functions: rule(\"…\"), site(#{ … })",
        _ => return None,
    })
}

/// What is wrong with a symbol that other languages have, and what to write in its place.
pub(super) fn symbol(symbol: &str) -> Option<(String, &'static str)> {
    let help = match symbol {
        "++" => "write x += 1",
        "--" => "write x -= 1",
        ":=" => "`=` gives a variable a value",
        "->" | "<-" => "what a value has stands behind a point: tip.ahead(80)",
        "===" => "write `==` to compare",
        "!==" => "write `!=` to compare",
        "?" => "write if a { 1 } else { 2 }",
        "#" => "a comment begins with `//`, a map with `#{`",
        "@" | "$" | "\\" => "names are made of letters, digits and `_`",
        _ => return None,
    };
    Some((format!("there is no `{symbol}`"), help))
}
