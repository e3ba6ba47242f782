// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Metal that yields, for large strains: the deformation is split into an elastic and a plastic part, F = F_e
// F_p (Lee 1969), and the elastic law is that of Hencky (1928) in the logarithmic strains e_a = ln l_a of the
// principal elastic stretches l_a. The Kirchhoff stress tau = P F^T has the principal values
//
//     tau_a = kappa (e_1 + e_2 + e_3) + 2 mu dev e_a
//     f     = |dev tau| - (2/3)^1/2 Y(a) <= 0,     Y = Y_0 + K a + (Y_inf - Y_0) (1 - exp(-r a))
//
// One backward Euler step from the last good state with the exponential map: in the principal axes of the
// trial state the return is that of small strains, e = e_trial - d gamma n with n = dev tau/|dev tau|, so the
// volume does not change by plastic flow (Simo 1992):
//
//     F_p^-1 = F_p,n^-1 N diag(exp(-d gamma n_a)) N^T
//
// where the columns of N are the axes of the trial C_e = F_p,n^-T C F_p,n^-1. The tangent is exact: the
// derivative of S_e by E_e in these axes has the entries
//
//     D_aabb = d tau_a/d e_b/(c_a c_b) - 2 delta_ab tau_a/c_a^2,      c_a = l_a^2 of the trial state
//     D_abab = mu' (ln c_a - ln c_b)/(c_a - c_b)/c_a - tau_b/(c_a c_b),  mu' = mu (1 - 2 mu d gamma/|dev
//     tau_trial|)
//
// without cancellation where stretches are equal. In a tension test the true stress is Y(a), and the
// logarithmic strain Y(a)/E + a.
//
// Reference: Lee, J. Appl. Mech. 36 (1969) 1-6; Simo, Comput. Methods Appl. Mech. Engrg. 99 (1992) 61-112; de
// Souza Neto, Peric & Owen, Computational Methods for Plasticity (2008), section 14.4.
//
//     subsection Solid
//       set Type                        = finite J2 plasticity
//       set Young modulus               = 206.9e9    # Pa
//       set Poisson ratio               = 0.29
//       set Yield stress                = 450e6      # Pa
//       set Isotropic hardening modulus = 129.24e6   # Pa
//       set Saturation stress           = 715e6      # Pa
//       set Saturation exponent         = 16.93
//     end

#include <dovetail/material/hardening.h>
#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/symmetric_tensor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Tensor;

namespace {

Tensor<2, 3> nine_numbers(const double *numbers)
{
  Tensor<2, 3> result;
  for (unsigned int i = 0; i < 9; ++i)
    result[i / 3][i % 3] = numbers[i];
  return result;
}

void write(const Tensor<2, 3> &tensor, double *numbers)
{
  for (unsigned int i = 0; i < 9; ++i)
    numbers[i] = tensor[i / 3][i % 3];
}

/// Sum of f(eigenvalue) n x n over the eigenpairs.
template <typename Function>
Tensor<2, 3> isotropic_function(const Tensor<2, 3> &A, const Function &f)
{
  Tensor<2, 3> result;
  for (const auto &[value, n] : eigenvectors(symmetrize(A), dealii::SymmetricTensorEigenvectorMethod::jacobi))
    result += f(value) * outer_product(n, n);
  return result;
}

} // namespace

class FiniteJ2Plasticity : public HyperelasticLaw
{
public:
  explicit FiniteJ2Plasticity(const Section &section)
      : moduli(section), U(Volumetric::logarithmic(moduli)), hardening(section)
  {
  }

  /// F_p^-1 - I; the logarithmic plastic strain -1/2 ln F_p^-1 F_p^-T, of the undeformed axes.
  std::vector<InternalVariable> internal_variables() const override
  {
    return {{"inverse plastic deformation", 9}, {"plastic strain", 9}, {"equivalent plastic strain"}};
  }

  std::optional<double> shear_of_flow() const override { return moduli.shear; }
  const Volumetric *volume() const override { return &U; }

  bool has_expansion_work() const override { return true; }
  /// Of W = s^3 (|dev tau_e|^2/(4 mu) + kappa/2 L^2) with s = 1 + e and L = ln det F_e = ln J - 3 ln s,
  /// @f[ \partial_e W = 3 s^2 \Bigl( \frac{|\mathrm{dev}\,\tau_e|^2}{4\mu} + \kappa \bigl(\tfrac12 L^2 -
  /// L\bigr)
  ///     \Bigr), @f]
  /// where the deviator and the flow do not depend on s, and d|dev tau_e| = (1 - c) 2 mu n : dF F^-1 with the
  /// share c of its growth that the flow takes.
  bool expansion_work(const Tensor<2, 3> &H, double e, const Tensor<2, 3> &H_n, const Place &place,
                      ExpansionWork &work) const override;

  /// The part that unloading gives back.
  double energy(const Tensor<2, 3> &H, const double e, const Place &place) const override
  {
    Response response; // the trial memory becomes that of the returned state
    static_cast<Place &>(response) = place;
    if (!evaluate(H, e, false, response))
      return std::numeric_limits<double>::quiet_NaN();
    const double s = 1 + e;
    Tensor<2, 3> H_e = H;
    for (unsigned int i = 0; i < 3; ++i)
      H_e[i][i] -= e;
    const Elastic elastic(*this, Deformation(H_e / s, place), response.memory.trial.data());
    return s * s * s * moduli.energy_of(elastic.kirchhoff_stress());
  }

protected:
  // With G = F_p^-1 and S_e of the principal axes, which F G turns: S = G S_e G^T.
  void elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    const Memory &memory = deformation.place.memory;
    Elastic elastic(*this, deformation, memory.accepted.data());
    std::copy(memory.accepted.begin(), memory.accepted.end(), memory.trial.begin());
    elastic.return_to_yield_surface(memory);
    const Tensor<2, 3> axes = elastic.G * elastic.N;
    Tensor<2, 3> S;
    for (unsigned int a = 0; a < 3; ++a)
      for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int j = 0; j < 3; ++j)
          S[i][j] += elastic.tau[a] / elastic.c[a] * axes[i][a] * axes[j][a];
    P = deformation.F * S;
    if (D == nullptr)
      return;
    *D = 0;
    add_material_stiffness(deformation.F, deformation.F, turned(elastic.stiffness(), axes), *D);
    add_geometric_stiffness(S, *D);
  }

  Tensor<4, 3> elastic_curvature(const Deformation &, const Tensor<2, 3> &) const override
  {
    AssertThrow(false, dealii::ExcNotImplemented());
    return {};
  }

private:
  using Three = std::array<double, 3>;

  /// The principal state with a plastic deformation.
  struct Elastic
  {
    /// @param memory of the plastic deformation
    Elastic(const FiniteJ2Plasticity &law, const Deformation &deformation, const double *memory);
    void return_to_yield_surface(const Memory &memory);
    Tensor<4, 3> stiffness() const;
    Tensor<2, 3> kirchhoff_stress() const ///< in its own axes
    {
      Tensor<2, 3> result;
      for (unsigned int a = 0; a < 3; ++a)
        result[a][a] = tau[a];
      return result;
    }

    const FiniteJ2Plasticity &law;
    Tensor<2, 3> G; ///< F_p^-1
    Tensor<2, 3> N;
    Three c, tau, n{};
    double volume_stress, norm = 0, size = 0;
    double lost = 0, along = 0; ///< of the shear modulus, and of that along n, by flow
  };

  const IsotropicModuli moduli;
  const Volumetric U;
  const IsotropicHardening hardening;
};

FiniteJ2Plasticity::Elastic::Elastic(const FiniteJ2Plasticity &law, const Deformation &deformation,
                                     const double *memory)
    : law(law), G(nine_numbers(memory))
{
  size = deformation.H.norm() + G.norm();
  const Tensor<2, 3> H_e = deformation.H + G + deformation.H * G; // F_e - I
  for (unsigned int i = 0; i < 3; ++i)
    G[i][i] += 1;
  const auto pairs = eigenvectors(symmetrize(Deformation(H_e).green_strain()),
                                  dealii::SymmetricTensorEigenvectorMethod::jacobi);
  Three strain;
  double sum = 0;
  for (unsigned int a = 0; a < 3; ++a) {
    for (unsigned int i = 0; i < 3; ++i)
      N[i][a] = pairs[a].second[i];
    c[a] = 1 + 2 * pairs[a].first;
    strain[a] = std::log1p(2 * pairs[a].first) / 2;
    sum += strain[a];
  }
  volume_stress = law.moduli.bulk_of_stress() * sum;
  for (unsigned int a = 0; a < 3; ++a) {
    n[a] = 2 * law.moduli.shear * (strain[a] - sum / 3);
    norm += n[a] * n[a];
    tau[a] = volume_stress + n[a];
  }
  norm = std::sqrt(norm);
  for (double &component : n)
    component /= norm > 0 ? norm : 1;
}

/// An accepted state is on the yield surface up to rounding, and must stay as it is.
void FiniteJ2Plasticity::Elastic::return_to_yield_surface(const Memory &memory)
{
  const double mu = law.moduli.shear, rounding = 1e-13, a_n = memory.accepted[18];
  const double f = norm - IsotropicHardening::root_of_two_thirds * law.hardening.strength(a_n);
  if (!(f > rounding * (norm + 2 * mu * size)))
    return;
  const double flow = law.hardening.find_flow(f, a_n, 2 * mu);
  const double a = a_n + IsotropicHardening::root_of_two_thirds * flow;
  lost = 2 * mu * flow / norm;
  along = 1 / (1 + law.hardening.slope(a) / (3 * mu)) - lost;
  Tensor<2, 3> change; // exp(-flow n) - I
  for (unsigned int b = 0; b < 3; ++b) {
    tau[b] = volume_stress + (1 - lost) * norm * n[b];
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        change[i][j] += std::expm1(-flow * n[b]) * N[i][b] * N[j][b];
  }
  const Tensor<2, 3> small = nine_numbers(memory.accepted.data()) + G * change; // F_p^-1 - I
  write(small, memory.trial.data());
  write(isotropic_function(small + transpose(small) + small * transpose(small),
                           [](const double x) { return -std::log1p(x) / 2; }),
        memory.trial.data() + 9);
  memory.trial[18] = a;
}

Tensor<4, 3> FiniteJ2Plasticity::Elastic::stiffness() const
{
  const double kappa = law.moduli.bulk_of_stress(), mu = law.moduli.shear * (1 - lost);
  Tensor<4, 3> D;
  for (unsigned int a = 0; a < 3; ++a)
    for (unsigned int b = 0; b < 3; ++b) {
      const double by_strain =
          kappa + 2 * mu * ((a == b) - 1. / 3) - 2 * law.moduli.shear * along * n[a] * n[b];
      D[a][a][b][b] += by_strain / (c[a] * c[b]) - (a == b ? 2 * tau[a] / (c[a] * c[a]) : 0);
      if (a == b)
        continue;
      const double x = (c[a] - c[b]) / c[b], logarithm = x == 0 ? 1 / c[b] : std::log1p(x) / (x * c[b]);
      D[a][b][a][b] = D[a][b][b][a] = mu * logarithm / c[a] - tau[b] / (c[a] * c[b]);
    }
  return D;
}

bool FiniteJ2Plasticity::expansion_work(const Tensor<2, 3> &H, const double e, const Tensor<2, 3> &H_n,
                                        const Place &place, ExpansionWork &work) const
{
  const double s = 1 + e, mu = moduli.shear, kappa = moduli.bulk_of_stress(), log_s = 3 * std::log1p(e);
  const Deformation whole(H), before(H_n);
  if (!(s > 0 && whole.J > 0 && before.J > 0))
    return undefined("the change of volume J = det F is " + in_words(whole.J) + ", but must be positive");
  const auto elastic_state =
      [&](Tensor<2, 3> gradient) { // with the plastic deformation of the last good step
        for (unsigned int i = 0; i < 3; ++i)
          gradient[i][i] -= e;
        return Elastic(*this, Deformation(gradient / s), place.memory.accepted.data());
      };
  Elastic elastic = elastic_state(H);
  const double stress_before = elastic_state(H_n).norm;
  const Tensor<2, 3> axes = whole.F / s * elastic.G * elastic.N; // their columns have the squares c
  elastic.return_to_yield_surface(place.memory);
  const double stress = (1 - elastic.lost) * elastic.norm;
  Tensor<2, 3> n; // dev tau_e/|dev tau_e|
  for (unsigned int a = 0; a < 3; ++a)
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        n[i][j] += elastic.n[a] / elastic.c[a] * axes[i][a] * axes[j][a];
  const Tensor<2, 3> inverse = transpose(invert(whole.F));
  const double L = std::log1p(whole.J_minus_1) - log_s, L_n = std::log1p(before.J_minus_1) - log_s;
  const double gain =
      (stress * stress - stress_before * stress_before) / (4 * mu) + kappa * (L - L_n) * ((L + L_n) / 2 - 1);
  work.value = 3 * s * s * gain;
  work.by_e = 6 * s * gain - 9 * s * kappa * (L - L_n);
  work.by_F =
      3 * s * s * ((1 - elastic.lost - elastic.along) * stress * (n * inverse) + kappa * (L - 1) * inverse);
  return true;
}

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<FiniteJ2Plasticity>(
    "finite J2 plasticity",
    "Metal that yields by von Mises' condition at large strains, with isotropic hardening.");
}

} // namespace dovetail
