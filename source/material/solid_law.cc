// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/hyperelastic_law.h>

#include <deal.II/base/symmetric_tensor.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Tensor;

namespace {
const std::string formulas = "; a law without memory takes a formula of x, y, z, t and T, too";
const std::string remedy = "give either Young modulus and Poisson ratio, or Shear modulus and Bulk modulus.";

/// The entry of the pair (first, second) which the scene sets, or "".
std::string one_set(const Section &section, const std::string &first, const std::string &second)
{
  return section.is_set(first) ? first : section.is_set(second) ? second : "";
}

/// U - I of the stretch U = C^1/2, by the eigenvectors of the Green strain, which are exact where it is
/// small.
Tensor<2, 3> stretch_minus_1(const Tensor<2, 3> &H)
{
  const dealii::SymmetricTensor<2, 3> E = symmetrize(Deformation(H).green_strain());
  Tensor<2, 3> result;
  for (const auto &[strain, axis] : eigenvectors(E, dealii::SymmetricTensorEigenvectorMethod::jacobi))
    result += 2 * strain / (1 + std::sqrt(1 + 2 * strain)) * outer_product(axis, axis);
  return result;
}
} // namespace

double SolidLaw::energy(const Tensor<2, 3> &H, const double e, const Place &place) const
{
  const double not_known = std::numeric_limits<double>::quiet_NaN();
  if (!internal_variables().empty() || (has_large_strain() && !(Deformation(H).J > 0)))
    return not_known;
  const Tensor<2, 3> free = e * Tensor<2, 3>(dealii::unit_symmetric_tensor<3>());
  const Tensor<2, 3> way = (has_large_strain() ? stretch_minus_1(H) : 0.5 * (H + transpose(H))) - free;
  const auto power = [&](const double s) {
    Response at_s;
    static_cast<Place &>(at_s) = place;
    return evaluate(free + s * way, e, false, at_s) ? scalar_product(at_s.P, way) : not_known;
  };
  return boost::math::quadrature::gauss_kronrod<double, 15>::integrate(power, 0., 1., 10, 1e-10);
}

bool is_mixed(const Section &solid)
{
  return solid.peek("Formulation") == "mixed";
}

double read_bulk_modulus(const Section &solid, const std::string &description)
{
  if (is_mixed(solid) && solid.peek("Bulk modulus") == "inf") {
    solid.require<std::string>("Bulk modulus", description);
    return std::numeric_limits<double>::infinity();
  }
  const double kappa = solid.require<double>("Bulk modulus", description);
  solid.check(kappa > 0, "Bulk modulus", "must be positive.");
  return kappa;
}

bool SolidLaw::depends_on_time() const
{
  return std::any_of(all_formulas.begin(), all_formulas.end(),
                     [](const Formula &formula) { return formula.value.depends_on_time(); });
}

bool SolidLaw::expansion_work(const Tensor<2, 3> &H, const double e, const Tensor<2, 3> &H_n,
                              const Place &place, ExpansionWork &work) const
{
  Response response;
  static_cast<Place &>(response) = place;
  if (!evaluate(H, e, true, response))
    return false;
  const Tensor<2, 3> change = H - H_n;
  work = {scalar_product(response.dP_de, change), 0, response.dP_de};
  if (!has_curvature())
    return true;
  const Curvature second = curvature(H, e, change, place);
  work.by_e = second.ee;
  work.by_F += second.Fe;
  return true;
}

double IsotropicModuli::energy_of(const Tensor<2, 3> &stress) const
{
  const double tr = trace(stress);
  return (stress.norm_square() - tr * tr / 3) / (4 * shear) + tr * tr / (18 * bulk);
}

std::array<std::string, 2> IsotropicModuli::entries(const Section &section)
{
  const std::string technical = one_set(section, "Young modulus", "Poisson ratio");
  const std::string invariant = one_set(section, "Shear modulus", "Bulk modulus");
  section.check(technical.empty() || invariant.empty(), invariant,
                "cannot be combined with " + technical + ": " + remedy);
  section.check(!technical.empty() || !invariant.empty(), "", "has no elastic moduli: " + remedy);
  if (invariant.empty())
    return {{"Young modulus", "Poisson ratio"}};
  return {{"Shear modulus", "Bulk modulus"}};
}

IsotropicModuli::IsotropicModuli(const Section &section) : is_mixed(dovetail::is_mixed(section))
{
  const bool is_technical = entries(section)[0] == "Young modulus";
  if (is_technical || section.documenting()) {
    const double E = section.require<double>("Young modulus", "Ratio of stress and strain in a tension test" +
                                                                  formulas + " [Pa]");
    const double nu = section.require<double>(
        "Poisson ratio",
        "Ratio of lateral and axial strain in a tension test, between -1 and 1/2" + formulas + " [-]");
    section.check(E > 0, "Young modulus", "must be positive.");
    section.check(nu > -1 && (is_mixed ? nu <= 0.5 : nu < 0.5), "Poisson ratio",
                  is_mixed ? "must be greater than -1 and not greater than 0.5."
                           : "must be greater than -1 and less than 0.5.");
    shear = E / (2 * (1 + nu));
    bulk = nu == 0.5 ? std::numeric_limits<double>::infinity() : E / (3 * (1 - 2 * nu));
  }
  if (!is_technical || section.documenting()) {
    shear = section.require<double>("Shear modulus",
                                    "mu, instead of Young modulus and Poisson ratio" + formulas + " [Pa]");
    bulk =
        read_bulk_modulus(section, "kappa (three-dimensional), instead of Young modulus and Poisson ratio" +
                                       formulas + " [Pa]");
    section.check(shear > 0, "Shear modulus", "must be positive.");
  }
}

} // namespace dovetail
