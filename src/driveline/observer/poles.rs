//! How slowly the errors of a method fade, for its tests.

use nalgebra::{Matrix4, Vector4};

/// Slowest pole [1/s] of x' = `errors` x, by inverse iteration: where no error is hidden, and the slowest one does not swing.
pub(super) fn slowest(errors: Matrix4<f64>) -> f64 {
    let inverse = errors.try_inverse().expect("all errors are seen");
    let mut x = Vector4::repeat(1.0);
    for _ in 0..50 {
        x = (inverse * x).normalize();
    }
    -1.0 / x.dot(&(inverse * x))
}

#[test]
fn of_poles_that_are_known_it_is_the_slowest() {
    let apart = Matrix4::from_diagonal(&Vector4::new(-3.0, -0.2, -7.0, -40.0));
    let turned = Matrix4::new_rotation(nalgebra::Vector3::new(0.3, -0.5, 0.2));
    let pole = slowest(turned * apart * turned.transpose());
    assert!((pole - 0.2).abs() < 1e-9, "{pole}");
}
