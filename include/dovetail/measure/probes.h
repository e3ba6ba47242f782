// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The numbers that the scene asks for by name.

#pragma once

#include <dovetail/measure/point_in_domain.h>
#include <dovetail/measure/reduction.h>
#include <dovetail/scene/note.h>
#include <dovetail/scene/units.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

#include <functional>
#include <map>
#include <optional>

namespace dovetail {

/// All probes of a scene: values of a field or a quantity (quantity.h) at points, what reduce() makes of them
/// in a domain or on a boundary, and resultants of a field's flux over boundaries (Reactions::resultant). At
/// a point that several cells have, a quantity is the mean of theirs.
///
///     set Probes = tip, heat out, worst
///     subsection Probe tip
///       set Domain = blade
///       set Point  = 0; 0.2; 0
///       set Field  = displacement
///     end
///     subsection Probe heat out
///       set Boundary = disk : 3, 4
///       set Field    = temperature
///       set Tolerance = 0.01
///     end
///     subsection Probe worst
///       set Domain   = blade
///       set Reduce   = maximum
///       set Quantity = von Mises
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

  bool is_empty() const { return probes.empty(); }
  bool has_motion() const; ///< some probe asks for velocities
  /// Before evaluate(), ghosted and kept by reference; nullptr: everything is at rest.
  void set_velocity(const Vector *velocity);

  /// About probes of fluxes at points where these are singular. Collective. @pre The model is paired.
  NoteList notes() const;
  /// About minima and maxima of fluxes at such points. Collective; @p solution is ghosted.
  NoteList notes_on_extremes(const Vector &solution, double t) const;

  struct Values
  {
    nlohmann::ordered_json numbers; ///< of each probe a number, or an array of components
    nlohmann::ordered_json
        places; ///< of each minimum and maximum likewise, in the place of a number its point
  };
  /// Collective; @p solution is ghosted.
  Values evaluate(const Vector &solution, const Reactions<dim> &reactions) const;

  const std::optional<Units> &units() const { return given_units; } ///< of the scene

  struct Probe
  {
    std::string name;
    Region<dim> region;           ///< of a point only its domain
    std::optional<Reduce> reduce; ///< over the region; of its flux the resultant if there is none
    std::optional<Field> field;   ///< this one, or else
    std::unique_ptr<Quantity<dim>> quantity;
    const Field *field_of_law = nullptr; ///< whose law the quantity asks
    std::optional<dealii::Point<dim>> X;
    std::vector<PointInCell<dim>> places; ///< of X, on this rank
    std::optional<Section> section;       ///< for error messages
    /// The quantity in another body with the same fields.
    std::function<std::unique_ptr<Quantity<dim>>(const Domain<dim> &domain)> make_quantity;
    double tolerance = 0; ///< of the estimated error, relative; 0: none is asked for
  };
  const std::vector<Probe> &all() const { return probes; }
  bool has_tolerance() const; ///< some probe
  static std::vector<double> evaluate(const Probe &probe, const Vector &solution,
                                      const Reactions<dim> &reactions,
                                      std::vector<dealii::Point<dim>> *places = nullptr);

private:
  static Probe read(const std::string &name, const Section &section, const Model<dim> &model);
  static void read_place(Probe &probe, const Section &section, const Model<dim> &model);
  static void read_tolerance(Probe &probe, const Section &section, const Model<dim> &model);

  const Model<dim> &model;
  std::optional<Units> given_units;
  std::vector<Probe> probes;
};

} // namespace dovetail
