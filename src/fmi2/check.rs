//! Faults of a table that the compiler reports: a wrong table does not become an FMU.

use crate::{Access, Causality, Variable};

/// Fails to compile, when called in a constant, if the table contradicts itself.
///
/// # Panics
/// For more than 8192 rows, a name that is empty or used twice, `min` above `max`, an output without `depends_on`, a
/// dependency that is no variable, a rate of anything but a Real input, and a slope of anything
/// but a Real output.
pub const fn check<M>(rows: &[Variable<M>]) {
    assert!(
        rows.len() <= crate::row::MOST,
        "a table has more than 8192 rows"
    );
    let mut index = 0;
    while index < rows.len() {
        let row = &rows[index];
        assert!(!row.name.is_empty(), "a variable has no name");
        assert!(
            position(rows, row.name) == index,
            "two variables have the same name"
        );
        check_limits(row);
        check_roles(row);
        if let Some(names) = row.dependencies {
            check_names(rows, names);
        }
        if let Some(names) = row.initial_dependencies {
            check_names(rows, names);
        }
        index += 1;
    }
}

const fn check_limits<M>(row: &Variable<M>) {
    if let (Some(min), Some(max)) = (row.min, row.max) {
        assert!(min <= max, "a variable's min is above its max");
    }
}

const fn check_roles<M>(row: &Variable<M>) {
    let real = matches!(row.access, Access::Real(_));
    let input = matches!(row.causality, Causality::Input);
    let output = matches!(row.causality, Causality::Output);
    assert!(
        !output || row.dependencies.is_some(),
        "an output lacks depends_on(...)"
    );
    assert!(
        row.rate.is_none() || (input && real),
        "a rate belongs to a Real input"
    );
    assert!(
        row.slope.is_none() || (output && real),
        "a slope belongs to a Real output"
    );
}

const fn check_names<M>(rows: &[Variable<M>], names: &[&str]) {
    let mut index = 0;
    while index < names.len() {
        assert!(
            position(rows, names[index]) < rows.len(),
            "a dependency is no variable"
        );
        index += 1;
    }
}

/// Index of the first row of that name; the number of rows if there is none.
const fn position<M>(rows: &[Variable<M>], name: &str) -> usize {
    let mut index = 0;
    while index < rows.len() && !same(rows[index].name, name) {
        index += 1;
    }
    index
}

/// Compares from the end: structured names differ there, and the compiler counts its work.
const fn same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut left = one.len();
    if left != other.len() {
        return false;
    }
    while left > 0 && one[left - 1] == other[left - 1] {
        left -= 1;
    }
    left == 0
}
