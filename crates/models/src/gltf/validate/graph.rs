//! Check that the nodes form a forest.

use crate::error::Fault;
use crate::gltf::document::Node;
use crate::gltf::fault::at;

/// All nodes, parents before their children, each with its parent. `nodes` name only nodes that there are, and each is a
/// child of one at most.
///
/// # Errors
/// When a node is its own ancestor.
pub(in crate::gltf) fn roots_first(nodes: &[Node]) -> Result<Vec<(usize, Option<usize>)>, Fault> {
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (number, node) in nodes.iter().enumerate() {
        for child in &node.children {
            parents[*child] = Some(number);
        }
    }
    let mut order: Vec<_> = (0..nodes.len()).filter(|node| parents[*node].is_none()).map(|node| (node, None)).collect();
    let mut next = 0;
    while let Some((parent, _)) = order.get(next).copied() {
        order.extend(nodes[parent].children.iter().map(|child| (*child, Some(parent))));
        next += 1;
    }
    if order.len() == nodes.len() {
        return Ok(order);
    }
    // Nodes that no root leads to have one parent each, so that their chain goes round in circles.
    let mut reached = vec![false; nodes.len()];
    order.iter().for_each(|(node, _)| reached[*node] = true);
    let lost = reached.iter().position(|reached| !reached).unwrap_or_default();
    Err(at(format!("nodes[{lost}]"), "is its own ancestor or below one that is: the nodes should make up trees"))
}
