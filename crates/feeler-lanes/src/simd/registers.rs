//! One register as a value with operators: shared by the levels with instructions of their own.

/// One register.
#[derive(Debug, Clone, Copy)]
pub struct One<T>(pub T);

/// Operators of registers by the instructions that do them.
macro_rules! operators {
    ($($trait:ident, $name:ident, $register:ty: $instruction:ident;)*) => {$(
        impl $trait for One<$register> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: such values are made with a token only.
                unsafe { One($instruction(self.0, other.0)) }
            }
        }
    )*};
}
pub(super) use operators;
