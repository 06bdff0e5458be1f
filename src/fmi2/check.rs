//! Faults of a table that the compiler reports: a wrong table does not become an FMU.

use crate::{Access, Alias, Causality, Enumeration, Variability, Variable};

/// Fails to compile, when called in a constant, if the table contradicts itself.
///
/// # Panics
/// For more than 8192 rows, a name that is empty or used twice, `min` above `max`, limits of what has none, an
/// enumeration whose items do not ascend, a difference of anything but Reals, an output without `depends_on`, a dependency that is no input (an initial
/// one: no input or parameter), a rate of anything but a continuous Real input, a slope of anything but a continuous
/// Real output, an alias that importers could set, and for `tunable`, `discrete`, `constant`, `on_demand`, `depends_on`
/// and `initially_depends_on` on a row that cannot be that.
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
        check_derivatives(row);
        check_aliases(rows, row);
        if let Some(names) = row.dependencies {
            check_names(rows, names, false);
        }
        if let Some(names) = row.initial_dependencies {
            check_names(rows, names, true);
        }
        index += 1;
    }
}

const fn check_limits<M>(row: &Variable<M>) {
    if let (Some(min), Some(max)) = (row.min, row.max) {
        assert!(min <= max, "a variable's min is above its max");
    }
    let limited = row.min.is_some() || row.max.is_some();
    assert!(
        !limited || matches!(row.access, Access::Real(_) | Access::Integer(_)),
        "limits belong to a Real or an Integer"
    );
    assert!(
        !row.relative || matches!(row.access, Access::Real(_)),
        "only a Real is a difference of values of a unit"
    );
    if let Access::Enumeration(_, kind) = row.access {
        check_items(kind);
    }
}

const fn check_items(kind: &Enumeration) {
    assert!(!kind.items.is_empty(), "an enumeration has no items");
    let mut index = 1;
    while index < kind.items.len() {
        assert!(
            kind.items[index - 1].value < kind.items[index].value,
            "the values of an enumeration do not ascend"
        );
        index += 1;
    }
}

const fn check_roles<M>(row: &Variable<M>) {
    let real = matches!(row.access, Access::Real(_));
    let computed = matches!(row.causality, Causality::Output | Causality::Local);
    let parameter = matches!(row.causality, Causality::Parameter);
    let fits = match row.variability {
        Variability::Fixed | Variability::Tunable => parameter,
        Variability::Discrete => !parameter,
        Variability::Continuous => real && !parameter,
        Variability::Constant => computed,
    };
    assert!(
        fits,
        "a variable has a variability that is not one of its causality: tunable is for parameters only, \
         constant for outputs and local variables"
    );
    check_constant(row);
    assert!(
        !matches!(row.causality, Causality::Output) || row.dependencies.is_some(),
        "an output lacks depends_on(...)"
    );
    let depends = row.dependencies.is_some() || row.initial_dependencies.is_some();
    assert!(
        computed || !depends,
        "only what the model computes depends on others"
    );
    assert!(
        computed || !row.on_demand,
        "only what the model computes is on demand"
    );
}

const fn check_constant<M>(row: &Variable<M>) {
    let on_nothing = matches!(row.dependencies, Some([])) && row.initial_dependencies.is_none();
    assert!(
        !matches!(row.variability, Variability::Constant) || (on_nothing && !row.on_demand),
        "a constant depends on nothing and is never computed"
    );
}

/// What a row is called besides.
const fn check_aliases<M>(rows: &[Variable<M>], row: &Variable<M>) {
    let mut index = 0;
    while index < row.aliases.len() {
        let alias = &row.aliases[index];
        assert!(!alias.name.is_empty(), "an alias has no name");
        assert!(
            position(rows, alias.name) == rows.len() && times(rows, alias.name) == 1,
            "two variables have the same name"
        );
        assert!(
            match alias.causality {
                Causality::Local => true,
                Causality::Output => matches!(row.causality, Causality::Output),
                Causality::Input | Causality::Parameter => false,
            },
            "an alias is local; that of an output may be an output"
        );
        index += 1;
    }
}

/// How many aliases have that name.
const fn times<M>(rows: &[Variable<M>], name: &str) -> usize {
    let (mut found, mut row) = (0, 0);
    while row < rows.len() {
        let aliases: &[Alias] = rows[row].aliases;
        let mut index = 0;
        while index < aliases.len() {
            found += same(aliases[index].name, name) as usize;
            index += 1;
        }
        row += 1;
    }
    found
}

const fn check_derivatives<M>(row: &Variable<M>) {
    let smooth =
        matches!(row.access, Access::Real(_)) && matches!(row.variability, Variability::Continuous);
    assert!(
        row.rate.is_none() || (smooth && matches!(row.causality, Causality::Input)),
        "a rate belongs to a continuous Real input"
    );
    assert!(
        row.slope.is_none() || (smooth && matches!(row.causality, Causality::Output)),
        "a slope belongs to a continuous Real output"
    );
}

/// `initially`: parameters count as well.
const fn check_names<M>(rows: &[Variable<M>], names: &[&str], initially: bool) {
    let mut index = 0;
    while index < names.len() {
        let at = position(rows, names[index]);
        assert!(at < rows.len(), "a dependency is no variable");
        let given = match rows[at].causality {
            Causality::Input => true,
            Causality::Parameter => initially,
            Causality::Output | Causality::Local => false,
        };
        assert!(
            given,
            "a dependency is no input; initially it may be a parameter too"
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
pub(crate) const fn same(one: &str, other: &str) -> bool {
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

#[cfg(test)]
mod tests {
    use super::check;
    use crate::{Alias, Causality, Enumeration, Item, Unit, Variable};

    type Row = Variable<(f64, i32, bool)>;

    const fn input() -> Row {
        Row::input("u", Unit::ONE, |m| &mut m.0, "")
    }

    const fn parameter() -> Row {
        Row::parameter("p", Unit::ONE, |m| &mut m.0, "")
    }

    const fn output() -> Row {
        Row::output("y", Unit::ONE, |m| &mut m.0, "").depends_on(&[])
    }

    const fn flag() -> Row {
        Row::boolean_input("f", |m| &mut m.2, "")
    }

    const fn count() -> Row {
        Row::integer_input("n", |m| &mut m.1, "")
    }

    const fn item(value: i32) -> Item {
        Item {
            name: "item",
            value,
            description: "",
        }
    }

    const fn kind(items: &'static [Item]) -> Enumeration {
        Enumeration {
            name: "Kind",
            description: "",
            items,
        }
    }

    const NONE: Enumeration = kind(&[]);
    const TWICE: Enumeration = kind(&[item(1), item(1)]);
    const SOUND: Enumeration = kind(&[item(-1), item(7)]);

    const fn choice(kind: &'static Enumeration) -> Row {
        Row::enumeration_input("k", kind, |m| &mut m.1, "")
    }

    const A: Alias = Alias::output("a", "");
    const U: Alias = Alias::output("u", "");
    const Y: Alias = Alias::output("y", "");
    const UNNAMED: Alias = Alias::output("", "");
    const LOCAL: Alias = Alias::local("a", "");
    const OTHER: Alias = Alias::local("b", "");
    const MORE: Alias = Alias::output("z1", "");
    const THIRD: Alias = Alias::local("z2", "");
    const SETTABLE: Alias = Alias {
        causality: Causality::Input,
        ..LOCAL
    };

    #[test]
    fn a_table_may_hold_every_row_that_a_description_can_tell() {
        check(&[
            input().min(0.0).max(0.0).rate(|m| &mut m.0),
            parameter().tunable().relative(),
            output()
                .depends_on(&["u", "f"])
                .initially_depends_on(&["p", "u"])
                .slope(|m| &mut m.0)
                .on_demand(),
            flag(),
            count().min(0.0),
            choice(&SOUND),
            Row::input("d", Unit::ONE, |m| &mut m.0, "").discrete(),
            Row::output("e", Unit::ONE, |m| &mut m.0, "")
                .discrete()
                .local(),
            Row::integer_output("i", |m| &mut m.1, "").depends_on(&["d"]),
            Row::integer_parameter("j", |m| &mut m.1, "")
                .tunable()
                .aliases(&[OTHER]),
            Row::boolean_output("c", |m| &mut m.2, "").constant(),
            Row::output("g", Unit::ONE, |m| &mut m.0, "")
                .local()
                .constant()
                .aliases(&[LOCAL]),
            Row::output("z", Unit::ONE, |m| &mut m.0, "")
                .depends_on(&[])
                .aliases(&[MORE, THIRD]),
        ]);
    }

    /// What the compiler says of a table.
    fn fault(rows: &[Row]) -> String {
        let panic = std::panic::catch_unwind(|| check(rows)).unwrap_err();
        let text = panic.downcast_ref::<&str>().copied();
        text.unwrap_or_default().into()
    }

    #[test]
    fn a_fault_of_a_table_is_told() {
        let of_causality = "a variable has a variability that is not one of its causality: \
                            tunable is for parameters only, constant for outputs and local variables";
        let given = "a dependency is no input; initially it may be a parameter too";
        let computed = "only what the model computes depends on others";
        let smooth_input = "a rate belongs to a continuous Real input";
        let constant = "a constant depends on nothing and is never computed";
        let twice = "two variables have the same name";
        let local = "an alias is local; that of an output may be an output";
        let limited = "limits belong to a Real or an Integer";
        let cases: &[(&[Row], &str)] = &[
            (&[input(), input()], twice),
            (
                &[Row::boolean_input("", |m| &mut m.2, "")],
                "a variable has no name",
            ),
            (
                &[input().min(1.0).max(0.0)],
                "a variable's min is above its max",
            ),
            (&[flag().min(0.0)], limited),
            (&[choice(&SOUND).max(1.0)], limited),
            (
                &[count().relative()],
                "only a Real is a difference of values of a unit",
            ),
            (&[choice(&NONE)], "an enumeration has no items"),
            (
                &[choice(&TWICE)],
                "the values of an enumeration do not ascend",
            ),
            (&[input().tunable()], of_causality),
            (&[output().tunable()], of_causality),
            (&[flag().tunable()], of_causality),
            (&[parameter().discrete()], of_causality),
            (&[input().constant()], of_causality),
            (&[parameter().constant()], of_causality),
            (&[output().depends_on(&["u"]).constant(), input()], constant),
            (&[output().constant().on_demand()], constant),
            (&[output().constant().initially_depends_on(&[])], constant),
            (&[output().aliases(&[Y])], twice),
            (&[output().aliases(&[U]), input()], twice),
            (&[output().aliases(&[A, A])], twice),
            (&[output().aliases(&[A]), input().aliases(&[LOCAL])], twice),
            (&[output().aliases(&[UNNAMED])], "an alias has no name"),
            (&[input().aliases(&[A])], local),
            (&[output().local().aliases(&[A])], local),
            (&[output().aliases(&[SETTABLE])], local),
            (
                &[Row::integer_output("y", |m| &mut m.1, "")],
                "an output lacks depends_on(...)",
            ),
            (&[input().depends_on(&[])], computed),
            (&[parameter().initially_depends_on(&[])], computed),
            (
                &[input().on_demand()],
                "only what the model computes is on demand",
            ),
            (
                &[output().depends_on(&["x"])],
                "a dependency is no variable",
            ),
            (&[output().depends_on(&["y"])], given),
            (&[parameter(), output().depends_on(&["p"])], given),
            (&[output().initially_depends_on(&["y"])], given),
            (&[count().rate(|m| &mut m.0)], smooth_input),
            (&[input().discrete().rate(|m| &mut m.0)], smooth_input),
            (
                &[input().slope(|m| &mut m.0)],
                "a slope belongs to a continuous Real output",
            ),
        ];
        for (rows, expected) in cases {
            assert_eq!(fault(rows), *expected);
        }
    }
}
