//! What a machine cannot make. In: a [`Drawing`](crate::Drawing), its size and the limits of a process; out: a report of what breaks
//! them, and a drawing that keeps them. Source: our own.
