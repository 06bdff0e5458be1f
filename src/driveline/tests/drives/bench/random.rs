//! Scenarios made by chance.

use super::Scenario;
use super::scenarios::{base, mm};
use super::sensors::Random;

/// A drive made by chance: launch, power on and off, shifts between the two gears, a hilly road.
pub fn random(seed: u64) -> Scenario {
    let mut random = Random(seed);
    let mut scenario = base(&format!("random {seed}"), 30.0);
    let (mut odd, mut even, mut t_e) = (vec![(0.5, 0.0)], vec![(0.5, 0.0)], vec![(0.5, 0.0)]);
    let launch = random.between(5.6, 6.4);
    odd.extend([(1.3, launch), (3.5, launch + 0.2), (4.2, 9.0)]);
    t_e.push((1.2, random.between(45.0, 75.0)));
    let (mut time, mut in_first) = (5.0, true);
    while time < 27.0 {
        let power = random.between(if in_first { -30.0 } else { -15.0 }, 95.0);
        t_e.extend([(time, power), (time + random.between(0.5, 2.0), power)]);
        time += random.between(2.2, 3.5);
        if random.uniform() < 0.6 {
            let (off, on) = if in_first {
                (&mut odd, &mut even)
            } else {
                (&mut even, &mut odd)
            };
            let (shift, torque) = (random.between(0.6, 1.2), random.between(20.0, 80.0));
            t_e.extend([(time, torque), (time + shift, torque)]);
            off.extend([
                (time - 0.3, 9.0),
                (time, 5.2),
                (time + 0.35 * shift, 2.5),
                (time + 0.5 * shift, 0.0),
            ]);
            on.extend([
                (time - 0.2, 0.0),
                (time, 2.4),
                (time + 0.4 * shift, 5.6),
                (time + shift, 6.6),
                (time + shift + 0.5, 9.0),
            ]);
            in_first = !in_first;
            time += shift + 1.2;
        }
    }
    let [one, two] = [&odd, &even].map(|knots| mm(knots));
    scenario.theta = [one, two];
    scenario.t_e = t_e;
    scenario.phi = (0..6)
        .map(|k| (5.0 * f64::from(k), random.between(-0.03, 0.05)))
        .collect();
    scenario
}
