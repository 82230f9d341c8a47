//! Numbers: every function over software `libm`, so that results are the same bits on every computer. Whole numbers are
//! taken wherever numbers are.

use crate::fault::{Complaint, Refusal};
use rhai::{Dynamic, Engine, EvalAltResult, FuncRegistration};

/// A number from a script: whole or not.
pub(crate) fn number(value: &Dynamic) -> Option<f64> {
    value.as_float().ok().or_else(|| value.as_int().ok().map(|whole| whole as f64))
}

/// A number argument, or the complaint that it is none. Finite numbers only.
pub(crate) fn numeric(what: &str, value: &Dynamic) -> Result<f64, Complaint> {
    match number(value) {
        Some(number) if number.is_finite() => Ok(number),
        Some(_) => Err(Complaint::new(format!("{what} must be a finite number")).hint("was something divided by 0?")),
        None => {
            let help =
                if value.is_string() { "numbers stand without quotes" } else { "write a number, such as 80 or 0.5" };
            Err(Complaint::new(format!("{what} must be a number, not {}", super::kind_of(value))).hint(help))
        }
    }
}

/// Registers a function of one number.
fn one(engine: &mut Engine, name: &'static str, f: fn(f64) -> f64) {
    FuncRegistration::new(name).with_params_info(["x: f64"]).register_into_engine(engine, f);
    FuncRegistration::new(name).with_params_info(["x: i64"]).register_into_engine(engine, move |x: i64| f(x as f64));
}

/// Registers a function of two numbers.
fn two(engine: &mut Engine, name: &'static str, names: [&str; 2], f: fn(f64, f64) -> f64) {
    let own = |a: &str, b: &str| [format!("{}: {a}", names[0]), format!("{}: {b}", names[1])];
    let new = |info: [String; 2]| FuncRegistration::new(name).with_params_info(info);
    new(own("f64", "f64")).register_into_engine(engine, f);
    new(own("i64", "f64")).register_into_engine(engine, move |x: i64, y: f64| f(x as f64, y));
    new(own("f64", "i64")).register_into_engine(engine, move |x: f64, y: i64| f(x, y as f64));
    new(own("i64", "i64")).register_into_engine(engine, move |x: i64, y: i64| f(x as f64, y as f64));
}

/// Registers all of them.
pub(crate) fn register(engine: &mut Engine) {
    for (name, f) in ONE {
        one(engine, name, f);
    }
    two(engine, "atan", ["y", "x"], libm::atan2);
    two(engine, "pow", ["base", "exponent"], libm::pow);
    two(engine, "hypot", ["x", "y"], libm::hypot);
    two(engine, "log", ["x", "base"], |x, base| libm::log(x) / libm::log(base));
    engine.register_fn("PI", || std::f64::consts::PI);
    ranges(engine);
    conversions(engine);
}

/// A function of one number.
type Function = fn(f64) -> f64;

/// Functions of one number. Angles of `sin` and its kin are radians.
const ONE: [(&str, Function); 17] = [
    ("sin", libm::sin),
    ("cos", libm::cos),
    ("tan", libm::tan),
    ("asin", libm::asin),
    ("acos", libm::acos),
    ("atan", libm::atan),
    ("exp", libm::exp),
    ("ln", libm::log),
    ("log", libm::log10),
    ("sqrt", f64::sqrt),
    ("floor", f64::floor),
    ("ceiling", f64::ceil),
    ("round", f64::round),
    ("fraction", f64::fract),
    ("to_float", |x| x),
    ("to_radians", f64::to_radians),
    ("to_degrees", f64::to_degrees),
];

fn ranges(engine: &mut Engine) {
    two(engine, "min", ["a", "b"], f64::min);
    two(engine, "max", ["a", "b"], f64::max);
    engine.register_fn("min", |a: i64, b: i64| a.min(b));
    engine.register_fn("max", |a: i64, b: i64| a.max(b));
    FuncRegistration::new("clamp").with_params_info(["x", "low", "high"]).register_into_engine(engine, clamp);
    FuncRegistration::new("mix").with_params_info(["a", "b", "share"]).register_into_engine(engine, mix);
}

fn conversions(engine: &mut Engine) {
    engine.register_fn("to_int", |x: i64| x);
    engine.register_fn("to_int", to_int);
    crate::words::getter(engine, "pct", "Percent: 12.pct is 0.12.", |x: &mut f64| *x / 100.0);
    crate::words::getter(engine, "pct", "Percent: 12.pct is 0.12.", |x: &mut i64| *x as f64 / 100.0);
}

/// `clamp(x, low, high)`.
fn clamp(x: Dynamic, low: Dynamic, high: Dynamic) -> Result<f64, Refusal> {
    let (x, low, high) = (numeric("x", &x)?, numeric("low", &low)?, numeric("high", &high)?);
    if low > high {
        return Err(Complaint::new("clamp: low is above high").into());
    }
    Ok(x.clamp(low, high))
}

/// `mix(a, b, share)`: from a at 0 to b at 1.
fn mix(a: Dynamic, b: Dynamic, share: Dynamic) -> Result<f64, Refusal> {
    let (a, b, share) = (numeric("a", &a)?, numeric("b", &b)?, numeric("share", &share)?);
    Ok(a + (b - a) * share)
}

/// Towards zero.
fn to_int(x: f64) -> Result<i64, Box<EvalAltResult>> {
    if x.abs() < i64::MAX as f64 {
        return Ok(x as i64);
    }
    Err(Complaint::new("to_int: the number does not fit a whole number").into())
}
