//! Setters of option structs, which are `#[non_exhaustive]`: a later option leaves the code of callers as it is.

/// Writes `with_` methods that set a field each. For the crates of feeler.
#[doc(hidden)]
#[macro_export]
macro_rules! setters {
    ($($with:ident: $field:ident: $type:ty),* $(,)?) => {
        $(
            #[doc = concat!("Sets [`", stringify!($field), "`](field@Self::", stringify!($field), ").")]
            #[must_use]
            pub fn $with(mut self, $field: $type) -> Self {
                self.$field = $field.into();
                self
            }
        )*
    };
}
