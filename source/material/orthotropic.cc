// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solids with three planes of symmetry: wood, laminates. Hooke's law with the orthonormal material axes a_1,
// a_2, a_3,
//
//     eps_11 = (s_11 - nu_12 s_22 - nu_13 s_33)/E_1 ...,   nu_21/E_2 = nu_12/E_1 ...,   2 eps_12 = s_12/G_12
//     ...
//
// for small displacements, P = C : (eps - e I), or in the Green strain E (large rotations, moderate strains),
//
//     W_e = E : C : E/2,     P_e = F S,     S = C : E
//
// Reference: Lekhnitskii, Theory of Elasticity of an Anisotropic Body (1963), section 5; Holzapfel, Nonlinear
// Solid Mechanics (2000), section 6.5.
//
//     subsection Solid
//       set Type           = orthotropic elastic      # or orthotropic Saint Venant-Kirchhoff
//       set Young moduli   = 11e9, 0.8e9, 0.5e9       # E_1, E_2, E_3, Pa
//       set Poisson ratios = 0.4, 0.45, 0.6           # nu_12, nu_13, nu_23
//       set Shear moduli   = 0.7e9, 0.6e9, 0.1e9      # G_12, G_13, G_23, Pa
//       set First axis     = cos(0.2*x); sin(0.2*x); 0
//       set Second axis    = 0; 1; 0
//     end

#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/lac/full_matrix.h>

#include <array>
#include <cmath>
#include <optional>

namespace dovetail {

using dealii::Tensor;

namespace {

/// C by the entries of a section, constant or at a point.
class OrthotropicStiffness
{
public:
  explicit OrthotropicStiffness(const Section &section)
      : first(section.read_expression("First axis", section.dimension() == 2 ? "1; 0" : "1; 0; 0",
                                      {section.dimension()},
                                      "a_1, of any length; a formula of x, y, z, t [-]"))
  {
    if (section.dimension() == 3)
      second =
          section.read_expression("Second axis", "0; 1; 0", {3},
                                  "Of it the part across a_1 gives a_2, and a_3 is across both; in 2D a_3 is "
                                  "the z axis [-]");
    const auto E = section.require<std::vector<double>>("Young moduli", "E_1, E_2, E_3 [Pa]");
    const auto nu = section.require<std::vector<double>>(
        "Poisson ratios", "nu_12, nu_13, nu_23: minus the strain along the second axis by that along the "
                          "first, which is pulled [-]");
    const auto G = section.require<std::vector<double>>("Shear moduli", "G_12, G_13, G_23 [Pa]");
    if (section.documenting())
      return;
    section.check(E.size() == 3, "Young moduli", "needs three numbers.");
    section.check(nu.size() == 3, "Poisson ratios", "needs three numbers.");
    section.check(G.size() == 3, "Shear moduli", "needs three numbers.");
    dealii::FullMatrix<double> compliance(3, 3);
    for (unsigned int a = 0; a < 3; ++a) {
      section.check(E[a] > 0, "Young moduli", "must be positive.");
      section.check(G[a] > 0, "Shear moduli", "must be positive.");
      shear[a] = G[a];
      compliance(a, a) = 1 / E[a];
      for (unsigned int b = a + 1; b < 3; ++b)
        compliance(a, b) = compliance(b, a) = -nu[a + b - 1] / E[a];
    }
    const double minor = compliance(0, 0) * compliance(1, 1) - compliance(0, 1) * compliance(0, 1);
    section.check(
        minor > 0 && compliance.determinant() > 0, "Poisson ratios",
        "are too large: some strain would have a negative energy (nu_12^2 must be less than E_1/E_2, and "
        "the determinant of the compliances positive).");
    normal.reinit(3, 3);
    normal.invert(compliance);
    if (first.depends_on_position() || second.depends_on_position() || depends_on_time())
      return;
    constant = at_axes({}, 0);
    section.check(constant.has_value(), "First axis",
                  first.n_components() == 2 ? "is zero, which is no direction."
                                            : "is zero or parallel to the Second axis, or that is zero.");
  }

  bool is_constant() const { return constant.has_value(); }
  bool depends_on_time() const { return first.depends_on_time() || second.depends_on_time(); }

  /// Nothing, and the reason is left, where the axes are none.
  std::optional<Tensor<4, 3>> at(const SolidLaw::Place &place) const
  {
    return constant ? constant : at_axes(place.X, place.t);
  }

private:
  static Tensor<1, 3> vector(const Expression &axis, const dealii::Point<3> &X, const double t)
  {
    Tensor<1, 3> result;
    for (unsigned int i = 0; i < axis.n_components(); ++i)
      result[i] = axis.value(X, t, i);
    return result;
  }

  std::optional<Tensor<4, 3>> at_axes(const dealii::Point<3> &X, const double t) const
  {
    std::array<Tensor<1, 3>, 3> axes;
    axes[0] = vector(first, X, t);
    axes[0] /= axes[0].norm();
    axes[1] = first.n_components() == 2 ? Tensor<1, 3>({-axes[0][1], axes[0][0], 0}) : vector(second, X, t);
    axes[1] -= (axes[1] * axes[0]) * axes[0];
    axes[1] /= axes[1].norm();
    axes[2] = cross_product_3d(axes[0], axes[1]);
    if (!std::isfinite(axes[2].norm_square())) {
      undefined("the First axis and the Second axis at " + in_words(X) + " are zero, parallel or no numbers",
                true);
      return std::nullopt;
    }
    Tensor<4, 3> C;
    for (unsigned int a = 0; a < 3; ++a)
      for (unsigned int b = 0; b < 3; ++b) {
        C += normal(a, b) * outer_product(outer_product(axes[a], axes[a]), outer_product(axes[b], axes[b]));
        if (a < b) {
          const Tensor<2, 3> ab = outer_product(axes[a], axes[b]) + outer_product(axes[b], axes[a]);
          C += shear[a + b - 1] * outer_product(ab, ab);
        }
      }
    return C;
  }

  const Expression first;
  Expression second;
  std::array<double, 3> shear{}; ///< of the planes 12, 13, 23
  dealii::FullMatrix<double> normal;
  std::optional<Tensor<4, 3>> constant;
};

/// C : E
Tensor<2, 3> stress_of(const Tensor<4, 3> &C, const Tensor<2, 3> &E)
{
  Tensor<2, 3> result;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      result[i][j] = scalar_product(C[i][j], E);
  return result;
}

} // namespace

class OrthotropicElastic : public SolidLaw
{
public:
  explicit OrthotropicElastic(const Section &section) : stiffness(section) {}

  bool evaluate(const Tensor<2, 3> &H, double e, bool with_derivatives, Response &response) const override
  {
    const auto C = stiffness.at(response);
    if (!C)
      return false;
    const Tensor<2, 3> I = dealii::unit_symmetric_tensor<3>();
    response.P = stress_of(*C, 0.5 * (H + transpose(H)) - e * I);
    if (with_derivatives) {
      response.dP_dF = *C;
      response.dP_de = -1. * stress_of(*C, I);
    }
    return std::isfinite(response.P.norm_square()) || undefined("the stress is not a finite number");
  }

  Curvature curvature(const Tensor<2, 3> &, double, const Tensor<2, 3> &, const Place &) const override
  {
    return {};
  }

  bool is_linear() const override { return true; }
  bool is_uniform() const override { return stiffness.is_constant(); }
  bool depends_on_time() const override { return stiffness.depends_on_time(); }

private:
  const OrthotropicStiffness stiffness;
};

class OrthotropicSaintVenantKirchhoff : public HyperelasticLaw
{
public:
  explicit OrthotropicSaintVenantKirchhoff(const Section &section) : stiffness(section) {}

  bool depends_on_time() const override { return stiffness.depends_on_time(); }

protected:
  bool is_defined(const Deformation &deformation) const override
  {
    return stiffness.at(deformation.place).has_value();
  }

  // D_iJkL = delta_ik S_JL + F_iA F_kB C_AJBL
  void elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    const Tensor<4, 3> C = *stiffness.at(deformation.place);
    const Tensor<2, 3> S = stress_of(C, deformation.green_strain());
    P = deformation.F * S;
    if (D == nullptr)
      return;
    *D = 0;
    add_material_stiffness(deformation.F, deformation.F, C, *D);
    add_geometric_stiffness(S, *D);
  }

  // (w_iA F_kB + F_iA w_kB) C_AJBL + delta_ik (C : F^T w)_JL
  Tensor<4, 3> elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const override
  {
    const Tensor<4, 3> C = *stiffness.at(deformation.place);
    const Tensor<2, 3> &F = deformation.F;
    Tensor<4, 3> result;
    add_material_stiffness(w, F, C, result);
    add_material_stiffness(F, w, C, result);
    add_geometric_stiffness(stress_of(C, transpose(F) * w), result);
    return result;
  }

private:
  const OrthotropicStiffness stiffness;
};

namespace {
[[maybe_unused]] const bool registered_linear = Catalogue<SolidLaw>::add<OrthotropicElastic>(
    "orthotropic elastic", "Hooke's law with three material axes, for small displacements.");
[[maybe_unused]] const bool registered_large = Catalogue<SolidLaw>::add<OrthotropicSaintVenantKirchhoff>(
    "orthotropic Saint Venant-Kirchhoff",
    "Hooke's law with three material axes in the Green strain: large rotations and moderate strains.");
} // namespace

} // namespace dovetail
