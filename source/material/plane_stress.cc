// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/plane_stress.h>
#include <dovetail/scene/undefined.h>

#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Tensor;

PlaneStress::PlaneStress(std::unique_ptr<SolidLaw> law_in_space) : law(std::move(law_in_space))
{
  for (const InternalVariable &variable : law->internal_variables())
    n_of_law += variable.n_components;
}

std::vector<InternalVariable> PlaneStress::internal_variables() const
{
  std::vector<InternalVariable> result = law->internal_variables();
  if (n_of_law > 0)
    result.push_back({"strain across"});
  return result;
}

void PlaneStress::pass(const Place &place) const
{
  if (n_of_law == 0)
    return;
  Place of_law = place;
  of_law.memory = place.memory.slice(0, n_of_law);
  law->pass(of_law);
}

bool PlaneStress::find_thickness(Tensor<2, 3> &H, const double e, Response &response) const
{
  const Memory memory = response.memory;
  if (n_of_law > 0)
    response.memory = memory.slice(0, n_of_law);
  const bool is_found =
      begin(H, e, n_of_law > 0 ? memory.accepted[n_of_law] : 0, response) && search(H, e, response);
  response.memory = memory;
  if (n_of_law > 0)
    memory.trial[n_of_law] = H[2][2];
  return is_found;
}

/// A law may end where its material is not stretched across but would be pressed together: then the search
/// begins where the volume does not change.
bool PlaneStress::begin(Tensor<2, 3> &H, const double e, const double last_strain, Response &response) const
{
  const double J = (1 + H[0][0]) * (1 + H[1][1]) - H[0][1] * H[1][0];
  const double without_change_of_volume = law->has_large_strain() ? 1 / J - 1 : -H[0][0] - H[1][1];
  for (const double strain : {last_strain, without_change_of_volume}) {
    H[2][2] = strain;
    if (law->evaluate(H, e, true, response))
      return true;
  }
  return false;
}

/// Newton's method, halved where the law is not defined and where the stress across does not become smaller
/// (the stress of a law that yields grows less and less on both sides, so that whole steps may go to and fro
/// for ever). It ends with a whole update that changes nothing any more, or that rounding alone keeps alive.
bool PlaneStress::search(Tensor<2, 3> &H, const double e, Response &response) const
{
  const unsigned int most_iterations = 50, most_halvings = 30;
  const double smallest_stretch = 1e-6, rounding = 1e-15, last_digits = 1e-12;
  double last_size = std::numeric_limits<double>::infinity();
  for (unsigned int iteration = 0; iteration < most_iterations; ++iteration) {
    double update = -response.P[2][2] / response.dP_dF[2][2][2][2];
    const double z = H[2][2], last_stress = std::abs(response.P[2][2]);
    unsigned int n_halvings = 0;
    for (bool is_good = false; !is_good; ++n_halvings, update /= 2) {
      H[2][2] = z + update;
      is_good =
          (!law->has_large_strain() || 1 + H[2][2] > smallest_stretch) && law->evaluate(H, e, true, response);
      if (is_good && std::abs(update) > last_digits * (std::abs(H[2][2]) + H.norm()))
        is_good = !(std::abs(response.P[2][2]) > last_stress);
      if (n_halvings == most_halvings)
        return undefined(
            "no thickness was found at which the stress across the plane vanishes (plane stress)");
    }
    const double size = std::abs(H[2][2] - z), scale = std::abs(z) + H.norm();
    const bool is_whole = n_halvings == 1;
    if (is_whole && (law->is_linear() || !(size > rounding * scale) ||
                     (size <= last_digits * scale && size >= last_size)))
      return std::isfinite(H[2][2]) || undefined("the strain across the plane is not a finite number");
    last_size = is_whole ? size : std::numeric_limits<double>::infinity();
  }
  return undefined("no thickness was found at which the stress across the plane vanishes (plane stress)");
}

bool PlaneStress::evaluate(const Tensor<2, 3> &H, const double e, const bool with_derivatives,
                           Response &response) const
{
  Tensor<2, 3> full = H;
  if (!find_thickness(full, e, response))
    return false;
  response.P[2][2] = 0;
  if (!with_derivatives)
    return true;
  const Tensor<2, 3> D_33 = response.dP_dF[2][2];
  const double stiffness = D_33[2][2], by_e = response.dP_de[2][2];
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J) {
      const double share = response.dP_dF[i][J][2][2] / stiffness;
      response.dP_dF[i][J] -= share * D_33;
      response.dP_de[i][J] -= share * by_e;
    }
  return true;
}

SolidLaw::Curvature PlaneStress::curvature(const Tensor<2, 3> &H, const double e, const Tensor<2, 3> &w,
                                           const Place &place) const
{
  Tensor<2, 3> full = H;
  Response response;
  static_cast<Place &>(response) = place;
  const bool is_defined = find_thickness(full, e, response);
  (void)is_defined;
  Assert(is_defined, dealii::ExcMessage("The curvature exists only where evaluate() succeeds."));
  const Tensor<2, 3> D_33 = response.dP_dF[2][2]; // by major symmetry also dP/dF_33
  Tensor<2, 3> w_full = w;
  w_full[2][2] = 0;
  w_full[2][2] = -scalar_product(w_full, D_33) / D_33[2][2];
  const Tensor<2, 3> z_F = -1. / D_33[2][2] * D_33;      // dz/dF
  const double z_e = -response.dP_de[2][2] / D_33[2][2]; // dz/de

  const Curvature K = law->curvature(full, e, w_full, place);
  const Tensor<2, 3> K_33 = K.FF[2][2];
  Curvature result = K;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      result.FF[i][J] += K_33[i][J] * z_F + z_F[i][J] * (K_33 + K_33[2][2] * z_F);
  result.Fe += z_e * K_33 + (K.Fe[2][2] + K_33[2][2] * z_e) * z_F;
  result.ee += 2 * K.Fe[2][2] * z_e + K_33[2][2] * z_e * z_e;
  return result;
}

std::optional<Tensor<2, 3>> PlaneStress::full_gradient(const Tensor<2, 3> &H, const double e,
                                                       const Place &place) const
{
  Tensor<2, 3> full = H;
  Response response;
  static_cast<Place &>(response) = place;
  return find_thickness(full, e, response) ? std::optional(full) : std::nullopt;
}

double PlaneStress::energy(const Tensor<2, 3> &H, const double e, const Place &place) const
{
  const auto full = full_gradient(H, e, place);
  if (!full)
    return std::numeric_limits<double>::quiet_NaN();
  Place of_law = place;
  if (n_of_law > 0)
    of_law.memory = place.memory.slice(0, n_of_law);
  return law->energy(*full, e, of_law);
}

} // namespace dovetail
