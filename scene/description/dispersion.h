// Indices of refraction that depend on the wavelength.
#pragma once

#include "core/simd/lanes.h"

#include <array>
#include <cstdlib>
#include <tuple>

namespace sheaf {

/// A dispersion formula in its published form, with wavelengths w in micrometers.
struct Dispersion {
  enum class Form {
    kSellmeier,     ///< n^2 = constant + sum of b w^2 / (w^2 - c)
    kSquarePowers,  ///< n^2 = constant + sum of b w^c
    kPowers,        ///< n = constant + sum of b w^c
  };
  struct Term {
    float b = 0, c = 0;  ///< c: square micrometers, or an even exponent
    static constexpr auto fields(auto& s) { return std::tie(s.b, s.c); }
  };

  Form form = Form::kSellmeier;
  float constant = 1;
  std::array<Term, 7> terms{};  ///< unused terms have b = 0

  static constexpr auto fields(auto& s) { return std::tie(s.form, s.constant, s.terms); }
};

/// Index of refraction at `lambda` nm, relative to air or, for some sources, to vacuum (at most a factor of 1.00027).
/// The formula is extrapolated where the measurement does not cover 360 to 830 nm.
template <class L> SHEAF_INLINE Float<L> ior(const Dispersion& d, typename L::Float lambda) {
  using F = typename L::Float;
  const F w2 = sqr(lambda * F(1e-3f));
  const auto power = [&](int exponent) {
    F product = F(1.0f);
    for (int k = 0; k < std::abs(exponent) / 2; ++k) product = product * w2;
    return exponent < 0 ? F(1.0f) / product : product;
  };
  F sum = F(d.constant);
  for (const Dispersion::Term& term : d.terms) {
    if (term.b == 0.0f) continue;
    const bool sellmeier = d.form == Dispersion::Form::kSellmeier;
    sum += F(term.b) * (sellmeier ? w2 / (w2 - F(term.c)) : power(static_cast<int>(term.c)));
  }
  return d.form == Dispersion::Form::kPowers ? sum : sqrt(sum);
}

/// Index of refraction at the helium d line, at which glasses are cataloged.
inline float catalog_ior(const Dispersion& d) { return ior<Scalar>(d, 587.56f); }

}  // namespace sheaf
