//! Fronts of error against length, from the shortest member to the longest, each with a smaller
//! error than all shorter ones.

/// Adds a member unless another one is as short and as good, and removes the members that it makes
/// superfluous. `of` returns number of operations and error of a member.
pub(crate) fn offer<T: Clone>(front: &mut Vec<T>, member: &T, of: impl Fn(&T) -> (u32, f64)) {
    let (operations, error) = of(member);
    let beats = |own: &T| of(own).0 <= operations && of(own).1 <= error;
    if front.iter().any(beats) {
        return;
    }
    front.retain(|own| of(own).0 < operations || of(own).1 < error);
    let place = front.partition_point(|own| of(own).0 < operations);
    front.insert(place, member.clone());
}
