//! Parameters that are the same everywhere, written into a function before it runs: reading one from `p` costs a call,
//! which a rule asked a million times feels.

use rhai::{ASTNode, Dynamic, Expr, Stmt, StmtBlock};

/// Puts the values of properties of a variable in the place of reading them, where `value` has one. Nothing is done in a
/// function that binds the name anew: what it means then hangs on the place.
pub(crate) fn settle(function: &mut StmtBlock, variable: &str, value: &dyn Fn(&str) -> Option<Dynamic>) {
    let binds = |statement: &Stmt| statement.walk(&mut Vec::new(), &mut |path| !is_binding(path, variable));
    if function.iter().all(binds) {
        Settling { variable, value }.block(function);
    }
}

/// Whether a node makes a name stand for something new, or lets a closure have it.
fn is_binding(path: &[ASTNode], name: &str) -> bool {
    let Some(ASTNode::Stmt(statement)) = path.last() else { return false };
    match statement {
        Stmt::Var(parts, ..) => parts.0.as_str() == name,
        Stmt::For(parts, ..) => parts.0.as_str() == name || parts.1.as_ref().is_some_and(|i| i.as_str() == name),
        Stmt::TryCatch(parts, ..) => matches!(&parts.expr, Expr::Variable(caught, ..) if caught.1.as_str() == name),
        Stmt::Import(parts, ..) => parts.1.as_str() == name,
        Stmt::Share(names) => names.iter().any(|(shared, _)| shared.as_str() == name),
        Stmt::Assignment(parts) => matches!(&parts.1.lhs, Expr::Variable(to, ..) if to.1.as_str() == name),
        _ => false,
    }
}

struct Settling<'a> {
    variable: &'a str,
    value: &'a dyn Fn(&str) -> Option<Dynamic>,
}

impl Settling<'_> {
    fn block(&self, block: &mut StmtBlock) {
        block.as_mut().iter_mut().for_each(|statement| self.statement(statement));
    }

    fn statement(&self, statement: &mut Stmt) {
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
            return;
        }
        match expression {
            Expr::Stmt(block) => self.block(block),
            Expr::InterpolatedString(parts, ..) | Expr::Array(parts, ..) => self.all(parts),
            Expr::Map(parts, ..) => parts.0.iter_mut().for_each(|(_, value)| self.expression(value)),
            Expr::Index(parts, ..) | Expr::Dot(parts, ..) => {
                self.expression(&mut parts.lhs);
                self.expression(&mut parts.rhs);
            }
            Expr::And(parts, ..) | Expr::Or(parts, ..) | Expr::Coalesce(parts, ..) => self.all(parts),
            Expr::FnCall(call, ..) | Expr::MethodCall(call, ..) => self.all(&mut call.args),
            _ => {}
        }
    }

    /// The value of an expression that reads a property of the variable and nothing more.
    fn settled(&self, expression: &Expr) -> Option<Expr> {
        let Expr::Dot(parts, ..) = expression else { return None };
        match (&parts.lhs, &parts.rhs) {
            (Expr::Variable(of, ..), Expr::Property(property, _)) if of.1.as_str() == self.variable => {
                let value = (self.value)(&property.2).filter(is_plain)?;
                Some(Expr::from_dynamic(value, expression.position()))
            }
            _ => None,
        }
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
        let text = format!("{declared}fn twice(q) {{ q.a * 2 }}\nfn propose(tip, p) {{\n{body}\n}}");
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
            "let f = |x| p.a; tip.ahead(f.call(0));",
            "tip.ahead({ let inner = p.a; inner });",
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
        assert_eq!(ahead("  p.a = 3; tip.ahead(p.a);").map_err(|told| told.starts_with("4:")), Err(true));
        assert_eq!(ahead("  tip.ahead(p.word);").map_err(|told| told.starts_with("4:")), Err(true));
        assert_eq!(ahead("  tip.ahead(p.missing);").map_err(|told| told.contains("missing")), Err(true));
    }
}
