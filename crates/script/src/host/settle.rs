//! Parameters that are the same everywhere, written into a function before it runs, and what follows from them alone:
//! reading one from `p` costs a call, which a rule asked a million times feels.

use rhai::{ASTNode, BinaryExpr, Dynamic, Expr, ImmutableString, Position, Stmt, StmtBlock};
use std::collections::BTreeMap;

/// Functions whose result hangs on their arguments alone.
const PURE: [&str; 17] = [
    "raster", "cross", "rings", "min", "max", "clamp", "mix", "sqrt", "pow", "floor", "ceiling", "round", "sin", "cos",
    "tan", "to_float", "to_int",
];

/// What a function is settled with.
#[derive(Clone, Copy)]
pub(crate) struct Settling<'a> {
    /// The variable that parameters are properties of.
    pub variable: &'a str,
    /// The value of a parameter that has one everywhere.
    pub value: &'a dyn Fn(&str) -> Option<Dynamic>,
    /// Evaluates what hangs on no variable; `None` where that fails.
    pub evaluate: &'a dyn Fn(&Expr) -> Option<Dynamic>,
    /// Whether the script has a function of its own of a name.
    pub is_own: &'a dyn Fn(&str) -> bool,
}

impl Settling<'_> {
    /// Puts values in the place of what reads them, and of what is computed from them alone. Nothing is done in a function
    /// that binds the variable anew: what it means then hangs on the place.
    pub fn settle(self, function: &mut StmtBlock) {
        if bindings(function.statements(), self.variable) > 0 {
            return;
        }
        let mut settler = Settler { with: self, known: BTreeMap::new() };
        // First what is never done is left out, so that it changes no variable.
        settler.block(function);
        for i in 0..function.len() {
            settler.statement(&mut function.as_mut()[i]);
            settler.known.extend(variable_for_good(&function.statements()[i..]));
        }
    }
}

/// A variable that the first of some statements makes of a constant, if none of the rest binds or changes it.
fn variable_for_good(statements: &[Stmt]) -> Option<(ImmutableString, Dynamic)> {
    let (Stmt::Var(parts, ..), rest) = statements.split_first()? else { return None };
    let value = parts.1.is_constant().then(|| parts.1.get_literal_value(None)).flatten()?;
    // Text has methods that change it.
    let is_number = value.is_float() || value.is_int() || value.is_bool();
    (is_number && bindings(rest, &parts.0.name) == 0).then(|| (parts.0.name.clone(), value))
}

/// How often statements bind a name, or change what it stands for.
fn bindings(statements: &[Stmt], name: &str) -> usize {
    let mut count = 0;
    for statement in statements {
        statement.walk(&mut Vec::new(), &mut |path| {
            count += usize::from(is_binding(path, name));
            true
        });
    }
    count
}

/// Whether a node makes a name stand for something new, or calls a method that might change it.
fn is_binding(path: &[ASTNode], name: &str) -> bool {
    let statement = match path.last() {
        Some(ASTNode::Stmt(statement)) => statement,
        Some(ASTNode::Expr(Expr::Dot(parts, ..))) => return calls_on(parts, name),
        _ => return false,
    };
    match statement {
        Stmt::Var(parts, ..) => parts.0.as_str() == name,
        Stmt::For(parts, ..) => parts.0.as_str() == name || parts.1.as_ref().is_some_and(|i| i.as_str() == name),
        Stmt::TryCatch(parts, ..) => matches!(&parts.expr, Expr::Variable(caught, ..) if caught.1.as_str() == name),
        Stmt::Import(parts, ..) => parts.1.as_str() == name,
        Stmt::Assignment(parts) => is_rooted_in(&parts.1.lhs, name),
        _ => false,
    }
}

/// Whether a chain calls a method on a variable itself.
fn calls_on(parts: &BinaryExpr, name: &str) -> bool {
    let is_call = match &parts.rhs {
        Expr::MethodCall(..) => true,
        Expr::Dot(rest, ..) | Expr::Index(rest, ..) => matches!(&rest.lhs, Expr::MethodCall(..)),
        _ => false,
    };
    is_call && matches!(&parts.lhs, Expr::Variable(of, ..) if of.1.as_str() == name)
}

/// Whether a place to assign to is a variable or a part of it.
fn is_rooted_in(place: &Expr, name: &str) -> bool {
    match place {
        Expr::Variable(to, ..) => to.1.as_str() == name,
        Expr::Index(parts, ..) | Expr::Dot(parts, ..) => is_rooted_in(&parts.lhs, name),
        _ => false,
    }
}

/// A function on the way.
struct Settler<'a> {
    with: Settling<'a>,
    /// Variables that stand for one constant from here on.
    known: BTreeMap<ImmutableString, Dynamic>,
}

impl Settler<'_> {
    fn block(&self, block: &mut StmtBlock) {
        block.as_mut().iter_mut().for_each(|statement| self.statement(statement));
    }

    fn statement(&self, statement: &mut Stmt) {
        self.parts(statement);
        let Stmt::If(parts, at) = statement else { return };
        if let Expr::BoolConstant(is_so, _) = parts.expr {
            let chosen = std::mem::take(if is_so { &mut parts.body } else { &mut parts.branch });
            *statement = if chosen.is_empty() { Stmt::Noop(*at) } else { Stmt::Block(Box::new(chosen)) };
        }
    }

    fn parts(&self, statement: &mut Stmt) {
        match statement {
            Stmt::If(parts, ..) | Stmt::While(parts, ..) | Stmt::Do(parts, ..) => {
                self.expression(&mut parts.expr);
                self.block(&mut parts.body);
                self.block(&mut parts.branch);
            }
            Stmt::TryCatch(parts, ..) => {
                self.block(&mut parts.body);
                self.block(&mut parts.branch);
            }
            Stmt::For(parts, ..) => {
                self.expression(&mut parts.2.expr);
                self.block(&mut parts.2.body);
            }
            Stmt::Switch(parts, ..) => {
                self.expression(&mut parts.0);
                for case in &mut parts.1.expressions {
                    self.expression(&mut case.lhs);
                    self.expression(&mut case.rhs);
                }
            }
            Stmt::Var(parts, ..) => self.expression(&mut parts.1),
            // What is assigned to is a place, not a value; its indices are left as they are.
            Stmt::Assignment(parts) => self.expression(&mut parts.1.rhs),
            Stmt::FnCall(call, ..) => self.all(&mut call.args),
            Stmt::Block(block) => self.block(block),
            Stmt::Expr(expression) => self.expression(expression),
            Stmt::BreakLoop(Some(value), ..) | Stmt::Return(Some(value), ..) => self.expression(value),
            _ => {}
        }
    }

    fn all(&self, expressions: &mut [Expr]) {
        expressions.iter_mut().for_each(|expression| self.expression(expression));
    }

    fn expression(&self, expression: &mut Expr) {
        if let Some(settled) = self.settled(expression) {
            *expression = settled;
        } else {
            self.inside(expression);
        }
    }

    fn inside(&self, expression: &mut Expr) {
        match expression {
            Expr::Stmt(block) => self.block(block),
            Expr::InterpolatedString(parts, ..) | Expr::Array(parts, ..) => self.all(parts),
            Expr::Map(parts, ..) => parts.0.iter_mut().for_each(|(_, value)| self.expression(value)),
            Expr::Dot(parts, ..) => {
                self.expression(&mut parts.lhs);
                self.rest(&mut parts.rhs);
            }
            Expr::Index(parts, ..) => {
                self.expression(&mut parts.lhs);
                self.index(&mut parts.rhs);
            }
            Expr::And(parts, ..) | Expr::Or(parts, ..) | Expr::Coalesce(parts, ..) => self.all(parts),
            Expr::FnCall(call, at) => {
                self.all(&mut call.args);
                let is_pure =
                    call.op_token.is_some() || (PURE.contains(&&*call.name) && !(self.with.is_own)(&call.name));
                let hangs_on_nothing = is_pure && call.args.iter().all(Expr::is_constant);
                let at = *at;
                if let Some(value) = hangs_on_nothing.then(|| (self.with.evaluate)(expression)).flatten() {
                    *expression = constant(value, at);
                }
            }
            _ => {}
        }
    }

    /// What follows a dot.
    fn rest(&self, rest: &mut Expr) {
        match rest {
            Expr::MethodCall(call, ..) => self.all(&mut call.args),
            Expr::Dot(parts, ..) => {
                self.rest(&mut parts.lhs);
                self.rest(&mut parts.rhs);
            }
            Expr::Index(parts, ..) => {
                self.rest(&mut parts.lhs);
                self.index(&mut parts.rhs);
            }
            _ => {}
        }
    }

    /// What stands in brackets, with what follows them: Rhai nests `l[i].x` as `l` and `i.x`, where it means `l[i]` and `x`.
    fn index(&self, index: &mut Expr) {
        match index {
            Expr::Dot(..) | Expr::Index(..) => self.inside(index),
            _ => self.expression(index),
        }
    }

    /// The value of an expression that reads a parameter, or a variable that stands for a constant, and nothing more.
    fn settled(&self, expression: &Expr) -> Option<Expr> {
        let value = match expression {
            Expr::Variable(of, ..) => self.known.get(&of.1).cloned(),
            Expr::Dot(parts, ..) => match (&parts.lhs, &parts.rhs) {
                (Expr::Variable(of, ..), Expr::Property(property, _)) if of.1.as_str() == self.with.variable => {
                    (self.with.value)(&property.2).filter(is_plain)
                }
                _ => None,
            },
            _ => None,
        };
        value.map(|value| constant(value, expression.position()))
    }
}

fn constant(value: Dynamic, at: Position) -> Expr {
    match is_plain(&value) {
        true => Expr::from_dynamic(value, at),
        false => Expr::DynamicConstant(Box::new(value), at),
    }
}

/// Whether a value is copied at no cost and means the same wherever it is written.
fn is_plain(value: &Dynamic) -> bool {
    value.is_float() || value.is_int() || value.is_bool() || value.is_string()
}

#[cfg(test)]
mod tests {
    use crate::{Faults, Host, Source, StreetPattern};
    use geom::{Bounds, Point, Seed};
    use std::sync::Arc;
    use streets::growth::{Fields, GrowthRules, Tip};

    /// The length that a function body asks for ahead, or what is told of it.
    fn ahead(body: &str) -> Result<f64, String> {
        let declared =
            "params(#{ a: metres(7).range(0, 100), yes: flag(true), word: choice(\"x\", [\"x\", \"y\"]) });\n";
        let text = format!(
            "{declared}fn twice(q) {{ q.a * 2 }} fn bump() {{ this += 1; }} fn turn() {{ this = !this; }} fn swap() {{ this = #{{ a: 7 }}; }}\nfn propose(tip, p) {{\n{body}\n}}"
        );
        let rule = Host::new(vec![]).rule_of("mine", &Source { text, path: "mine.rhai".into() });
        let rule = rule.map_err(|fault| fault.to_string())?;
        let faults = Arc::new(Faults::default());
        let pattern = StreetPattern::new(rule, 0, Arc::new(streets::Classes::default()), faults.clone());
        let bounds = Bounds::between(Point::new(0, 0), Point::new(1024, 1024));
        let mut tip = Tip::new(streets::Classes::MINOR, Seed(1), Arc::new(Fields::plain(bounds)));
        pattern.propose(&mut tip);
        match faults.sorted().first() {
            Some(fault) => Err(format!("{}:{} {}", fault.line, fault.column, fault.message)),
            None => tip.slots.ahead.map(|slot| slot.length).ok_or_else(|| "nothing ahead".to_owned()),
        }
    }

    #[test]
    fn a_function_says_the_same_whatever_its_form() {
        let bodies = [
            "tip.ahead(p.a);",
            "if p.yes && p.a > 6 { tip.ahead(p.a) } else { tip.ahead(1) }",
            "let n = 0; while n < p.a { n += p.a; } tip.ahead(n);",
            "let n = 0; do { n += p.a } until n >= p.a; tip.ahead(n);",
            "let n = 0; loop { n += 1; if n >= p.a { break; } } tip.ahead(p.a);",
            "let n = 0; for i in [p.a, 0] { n += i } tip.ahead(n);",
            "tip.ahead(switch p.word { \"x\" => p.a, _ => 1 });",
            "let m = #{ l: p.a }; m.l = p.a; tip.ahead(m.l);",
            "let l = [0, p.a]; tip.ahead(l[1]);",
            "if `${p.a}` == `${twice(p) / 2}` { tip.ahead(7) }",
            "try { throw p.a; } catch (e) { tip.ahead(e); }",
            "tip.ahead(twice(p) / 2);",
            "let q = p; tip.ahead(q.a);",
            "let f = |q| q.a; tip.ahead(f.call(p));",
            "let f = |q, x| x + q.a; tip.ahead(f.call(p, 0));",
            "tip.ahead({ let inner = p.a; inner });",
            "if p.a < 6 { tip.ahead(1) } else if p.a + 1 == 8 { tip.ahead(-(-p.a)) }",
            "let n = if p.yes { p.a } else { 2 }; tip.ahead(n);",
            "if !p.yes { return; } if p.a > 100 { } tip.ahead(max(p.a, sqrt(p.a * p.a)));",
            "tip.steer(raster(0, p.a * 10, 20)); tip.ahead(p.a);",
            "let n = p.a; if p.a > 100 { n *= 2; } tip.ahead(n);",
            "let n = p.a; n += 1; tip.ahead(n - 1);",
            "let n = p.a; { let n = 3; n += 1; } tip.ahead(n);",
            "let n = p.a; for n in 0..3 { n + 1; } tip.ahead(n);",
            "let n = 1; let n = p.a; tip.ahead(n);",
            "let n = p.a; let m = n * 2; tip.ahead(m / 2);",
            "if p.yes { let n = p.a; tip.ahead(n); }",
            "let never = |x, tip| { let z = x; tip.ahead(1); throw z; }; tip.ahead(p.a);",
            "let n = p.a; let f = |x| { let z = x * 2; z + 1 }; tip.ahead(f.call(3));",
            "let n = p.a; n.bump(); tip.ahead(n - 1);",
            "let yes = p.yes; yes.turn(); tip.ahead(if yes { 1 } else { p.a });",
            "p.swap(); tip.ahead(p.a);",
            "let l = [3, 7]; let i = 1; tip.ahead(l[i]);",
            "let l = [[3], [7]]; let i = 0; tip.ahead(l[i + 1][i]);",
            "let l = [#{ a: 7 }]; let i = 0; tip.ahead(l[i].a);",
            "let w = p.word; w.clear(); tip.ahead(if w == p.word { 1 } else { p.a });",
            "let l = [1]; l.push(p.a); tip.ahead(l[1]);",
            "let p = #{ a: p.a }; tip.ahead(p.a);",
            "if true { let p = #{ a: 7 }; tip.ahead(p.a); return; } tip.ahead(p.a + 1);",
            "for p in [#{ a: 7 }] { tip.ahead(p.a); }",
            "for (p, i) in [#{ a: 7 }] { tip.ahead(p.a + i); }",
            "try { throw #{ a: 7 }; } catch (p) { tip.ahead(p.a); }",
            "p = #{ a: 7 }; tip.ahead(p.a);",
        ];
        for body in bodies {
            assert_eq!(ahead(body), Ok(7.0), "{body}");
        }
    }

    #[test]
    fn faults_stand_where_they_stood() {
        assert_eq!(ahead("  tip.steer(raster(0, -p.a, 20));").map_err(|told| told.starts_with("4:")), Err(true));
        assert_eq!(ahead("  let l = [1, 2]; tip.ahead(l[p].a);").map_err(|told| told.starts_with("4:")), Err(true));
        assert_eq!(ahead("  p.a = 3; tip.ahead(p.a);").map_err(|told| told.starts_with("4:")), Err(true));
        assert_eq!(ahead("  tip.ahead(p.word);").map_err(|told| told.starts_with("4:")), Err(true));
        assert_eq!(ahead("  tip.ahead(p.missing);").map_err(|told| told.contains("missing")), Err(true));
    }
}
