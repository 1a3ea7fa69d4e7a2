// Visitors of variants.
#pragma once

namespace sheaf {

/// Overload set for std::visit.
template <class... F> struct Overloaded : F... { using F::operator()...; };
template <class... F> Overloaded(F...) -> Overloaded<F...>;

}  // namespace sheaf
