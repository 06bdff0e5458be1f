//! Which output an input takes.

use super::{Place, Role, Signal};

/// An output and an input that takes it: index of the component and place in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wire {
    pub(super) from: (usize, Place),
    pub(super) to: (usize, Place),
}

/// The wires between components: equal names, equal types, from the nearest one before, going round.
pub(super) fn wires(components: &[&[Signal]]) -> Vec<Wire> {
    let count = components.len();
    let mut wires = Vec::new();
    for (at, signals) in components.iter().enumerate() {
        for input in signals.iter().filter(|one| one.role == Role::Input) {
            let others = (1..count).map(|back| (at + count - back) % count);
            let given = others.filter_map(|from| Some((from, output(components[from], input)?)));
            wires.extend(given.take(1).map(|from| Wire {
                from,
                to: (at, input.place),
            }));
        }
    }
    wires
}

fn output(signals: &[Signal], input: &Signal) -> Option<Place> {
    let mut outputs = signals.iter().filter(|one| one.role == Role::Output);
    let found = outputs.find(|one| one.name == input.name && one.place.kind == input.place.kind);
    found.map(|found| found.place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Kind;

    fn signal(name: &str, role: Role, reference: u32) -> Signal {
        let kind = Kind::Real;
        Signal {
            name: name.into(),
            role,
            place: Place { kind, reference },
        }
    }

    #[test]
    fn an_input_takes_the_nearest_output_before_it() {
        let plant = [
            signal("position", Role::Input, 0),
            signal("torque", Role::Output, 1),
        ];
        let observer = [signal("torque", Role::Output, 0)];
        let control = [
            signal("torque", Role::Input, 0),
            signal("position", Role::Output, 1),
        ];
        let ends: Vec<_> = wires(&[&plant, &observer, &control])
            .iter()
            .map(|wire| (wire.from.0, wire.to.0))
            .collect();
        assert_eq!(ends, [(2, 0), (1, 2)], "the estimate, not the truth");
    }

    #[test]
    fn names_of_another_type_are_not_wired() {
        let mut output = signal("a", Role::Output, 0);
        output.place.kind = Kind::Integer;
        assert_eq!(wires(&[&[output], &[signal("a", Role::Input, 0)]]), []);
    }
}
