// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The numbers that the scene asks for by name.

#pragma once

#include <dovetail/output/reactions.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

#include <optional>

namespace dovetail {

/// All probes of a scene: values of a field at points, and resultants of its flux over boundaries
/// (Reactions::resultant).
///
///     set Probes = tip, heat out
///     subsection Probe tip
///       set Domain = blade
///       set Point  = 0; 0.2; 0
///       set Field  = displacement
///     end
///     subsection Probe heat out
///       set Boundary = disk : 3, 4
///       set Field    = temperature
///     end
template <int dim>
class Probes
{
public:
  /// Reads the sections and finds the points. Collective.
  /// @throw UserError if a point is outside its domain.
  Probes(const Section &scene, const Model<dim> &model);

  /// Find the points again after the meshes have changed. Collective.
  void locate_again();

  /// A number for scalars, an array for vectors. Collective; @p solution is ghosted.
  nlohmann::ordered_json evaluate(const Vector &solution, const Reactions<dim> &reactions) const;

private:
  /// A body is found at a point up to this fraction of the cell's size: typed coordinates are rounded, and
  /// the facets of a curved body leave a part of it out.
  static constexpr double tolerance_of_straight = 1e-3, tolerance_of_curved = 0.1;

  struct Probe
  {
    std::string name;
    const Domain<dim> *domain = nullptr;
    Field field;
    std::set<dealii::types::boundary_id> boundary_ids; ///< empty: a point
    std::optional<Section> section;                    ///< for error messages
    dealii::Point<dim> X;
    // of a point, on the one rank that evaluates it:
    std::vector<dealii::types::global_dof_index> dofs; ///< component, node; empty on the others
    std::vector<double> shape_values;
  };

  static Probe read(const std::string &name, const Section &section, const Model<dim> &model);
  static void locate(Probe &probe, const MPI_Comm &communicator);
  [[noreturn]] static void fail_outside(const Probe &probe, const MPI_Comm &communicator);

  const Model<dim> &model;
  std::vector<Probe> probes;
};

} // namespace dovetail
