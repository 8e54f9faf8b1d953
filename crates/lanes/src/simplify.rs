//! Fewer scopes and exits in a tree of control flow.

use crate::program::Instruction::Compute;
use crate::program::{Kind, Label, Node, Operation, Program, Target, Value};

impl Program {
    /// Drops exits that lead where the tree goes on anyway, scopes that nothing leaves and what no lane comes to. Of two
    /// ways, one that leaves comes first: what follows then belongs to the other.
    pub fn simplify(&mut self) {
        let body = std::mem::take(&mut self.body);
        let mut left = vec![];
        self.body = self.simplified(body, &[], &mut left);
    }

    /// `ends` are the labels that lead where the list `nodes` ends; `left` is told of all that it leaves.
    fn simplified(&mut self, nodes: Vec<Node>, ends: &[Label], left: &mut Vec<Label>) -> Vec<Node> {
        let mut list: Vec<Node> = vec![];
        let count = nodes.len();
        for (i, node) in nodes.into_iter().enumerate() {
            let ends = if i + 1 == count { ends } else { &[] };
            match node {
                Node::Exit(label) if ends.contains(&label) => {}
                Node::Exit(label) => {
                    left.push(label);
                    list.push(node);
                }
                Node::Switch { ref cases, default, .. } => {
                    left.extend(cases.iter().map(|(_, label)| *label).chain([default]));
                    list.push(node);
                }
                Node::Run(more) => match list.last_mut() {
                    Some(Node::Run(run)) => run.extend(more),
                    _ => list.push(Node::Run(more)),
                },
                Node::If { condition, yes, no, live } => {
                    let yes = self.simplified(yes, ends, left);
                    let no = self.simplified(no, ends, left);
                    if yes.is_empty() && no.is_empty() {
                        continue;
                    }
                    if (falls(&yes) && !falls(&no)) || yes.is_empty() {
                        let inverse = self.inverse(condition, &mut list);
                        list.push(Node::If { condition: inverse, yes: no, no: yes, live });
                    } else {
                        list.push(Node::If { condition, yes, no, live });
                    }
                }
                Node::Loop { body, live } => {
                    let body = self.simplified(body, &[], left);
                    list.push(Node::Loop { body, live });
                }
                Node::Scope { label, body, live, .. } => {
                    let mut inner = vec![];
                    let body = self.simplified(body, &[ends, &[label]].concat(), &mut inner);
                    let needed = inner.contains(&label);
                    inner.retain(|other| *other != label);
                    let outward = inner.iter().any(|label| !is_within(&body, *label));
                    left.extend(inner);
                    if needed {
                        list.push(Node::Scope { label, body, outward, live });
                        continue;
                    }
                    for node in body {
                        match (list.last_mut(), node) {
                            (Some(Node::Run(run)), Node::Run(more)) => run.extend(more),
                            (_, node) => list.push(node),
                        }
                    }
                }
            }
            if !falls(&list) {
                break;
            }
        }
        list
    }

    fn inverse(&mut self, condition: Value, list: &mut Vec<Node>) -> Value {
        let register = self.register(Kind::Bool);
        let to = Target::from(register);
        let compute = Compute { operation: Operation::Call("inverse"), to, from: vec![condition] };
        match list.last_mut() {
            Some(Node::Run(run)) => run.push(compute),
            _ => list.push(Node::Run(vec![compute])),
        }
        Value::Register(register)
    }
}

/// Whether the scope `label` is among `nodes` or in them.
fn is_within(nodes: &[Node], label: Label) -> bool {
    nodes.iter().any(|node| match node {
        Node::Run(_) | Node::Exit(_) | Node::Switch { .. } => false,
        Node::If { yes, no, .. } => is_within(yes, label) || is_within(no, label),
        Node::Loop { body, .. } => is_within(body, label),
        Node::Scope { label: inner, body, .. } => *inner == label || is_within(body, label),
    })
}

/// Whether lanes may come to the end of a list.
pub fn falls(nodes: &[Node]) -> bool {
    nodes.iter().all(|node| match node {
        Node::Exit(_) | Node::Switch { .. } | Node::Loop { .. } => false,
        Node::If { yes, no, .. } => falls(yes) || falls(no),
        Node::Scope { .. } | Node::Run(_) => true,
    })
}
