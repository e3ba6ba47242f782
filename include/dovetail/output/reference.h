// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Errors against the solution of another run.

#pragma once

#include <dovetail/output/samples.h>

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace dovetail {

/// The entries `Samples` and `Reference` of the section `Output`. Without them nothing happens.
///
/// Errors against a reference are sums over its points X_k with their weights w_k,
///     L2 = (sum w_k |u(X_k) - u_ref(X_k)|^2)^1/2,   H1 likewise of the gradients,
/// and stand where errors against `Exact` would stand. A point outside this mesh (curved bodies, coarse
/// meshes) takes the polynomial of the nearest cell if that is less than a third of the cell away; the share
/// of the weight that is left out is "reference points outside".
///
/// The flux of an interface is compared at this run's points; that of the reference comes from an affine fit
/// to its nearest points, which errs by O(h_ref^2). Its sides may be swapped; if they are others, there is no
/// comparison.
template <int dim>
class Reference
{
public:
  /// Reads the entries and the first line of the file. Collective. @throw UserError if the file does not fit.
  Reference(const Section &output, const Model<dim> &model);

  bool is_on() const { return !samples_file.empty() || reference.has_value(); }
  bool has_reference() const { return reference.has_value(); }
  const std::string &file() const { return reference_file; }

  /// Write the samples, unless the solution is not converged, and replace "errors" and "norms" of the domains
  /// and "flux error L2" of the interfaces in the report's parts. Collective; @p solution is ghosted.
  void compare(const Vector &solution, double t, bool is_converged, nlohmann::ordered_json &domains,
               nlohmann::ordered_json &interfaces) const;

private:
  void check_fields(const Section &output) const;
  void compare_domain(const Domain<dim> &domain, const Samples::Part &part, const Vector &solution,
                      nlohmann::ordered_json &result) const;
  /// @param sign -1 if what is the source here was the destination there
  void compare_interface(const Interface<dim> &interface, const Samples::Part &part, double sign,
                         const Vector &solution, double t, nlohmann::ordered_json &result) const;

  const Model<dim> &model;
  std::string samples_file, reference_file;
  std::optional<Samples> reference;
};

} // namespace dovetail
