// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/solid_law.h>

#include <limits>

namespace dovetail {

namespace {
const std::string remedy = "give either Young modulus and Poisson ratio, or Shear modulus and Bulk modulus.";

/// The entry of the pair (first, second) which the scene sets, or "".
std::string one_set(const Section &section, const std::string &first, const std::string &second)
{
  return section.is_set(first) ? first : section.is_set(second) ? second : "";
}
} // namespace

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

IsotropicModuli::IsotropicModuli(const Section &section) : is_mixed(dovetail::is_mixed(section))
{
  const std::string technical = one_set(section, "Young modulus", "Poisson ratio");
  const std::string invariant = one_set(section, "Shear modulus", "Bulk modulus");
  section.check(technical.empty() || invariant.empty(), invariant,
                "cannot be combined with " + technical + ": " + remedy);
  section.check(!technical.empty() || !invariant.empty(), "", "has no elastic moduli: " + remedy);

  if (!technical.empty() || section.documenting()) {
    const double E =
        section.require<double>("Young modulus", "Ratio of stress and strain in a tension test [Pa]");
    const double nu = section.require<double>(
        "Poisson ratio", "Ratio of lateral and axial strain in a tension test, between -1 and 1/2 [-]");
    section.check(E > 0, "Young modulus", "must be positive.");
    section.check(nu > -1 && (is_mixed ? nu <= 0.5 : nu < 0.5), "Poisson ratio",
                  is_mixed ? "must be greater than -1 and not greater than 0.5."
                           : "must be greater than -1 and less than 0.5.");
    shear = E / (2 * (1 + nu));
    bulk = nu == 0.5 ? std::numeric_limits<double>::infinity() : E / (3 * (1 - 2 * nu));
  }
  if (!invariant.empty() || section.documenting()) {
    shear = section.require<double>("Shear modulus", "mu, instead of Young modulus and Poisson ratio [Pa]");
    bulk = read_bulk_modulus(section,
                             "kappa (three-dimensional), instead of Young modulus and Poisson ratio [Pa]");
    section.check(shear > 0, "Shear modulus", "must be positive.");
  }
}

} // namespace dovetail
