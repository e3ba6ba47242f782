// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/rehearsal.h>

#include <dovetail/measure/body_size.h>
#include <dovetail/output/table.h>
#include <dovetail/system/free_motions.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>

namespace dovetail {

namespace {

const NoteName of_free_motion("free motion", "--check finds a motion that nothing holds");

std::string five_digits(const double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.5g", value);
  return text;
}

/// Of the law of the solid or, if it gives none, of the heat; 0 if there is none.
double density_of(const Section &scene, const std::string &material)
{
  for (const char *const part : {"Solid", "Heat"})
    if (const double density =
            std::strtod(scene.peek("Material " + material + "/" + part, "Density").c_str(), nullptr);
        density > 0)
      return density;
  return 0;
}

template <int dim>
std::string extent(const BodySize<dim> &size)
{
  std::string words;
  for (unsigned int d = 0; d < dim; ++d)
    words += (d == 0 ? "" : " x ") + five_digits(size.low[d]) + " ... " + five_digits(size.high[d]);
  return words;
}

/// "flank, 3" of an id that has names.
std::string names_of_boundary(const dealii::types::boundary_id id, const BoundaryNames &names)
{
  std::vector<std::string> all;
  for (const auto &[name, ids] : names)
    if (name != std::to_string(id) && std::find(ids.begin(), ids.end(), id) != ids.end())
      all.push_back(name);
  return all.empty() ? "" : comma_separated(all);
}

template <int dim>
void tell_bodies(const Model<dim> &model, const std::vector<BodySize<dim>> &sizes, const Section &scene,
                 Log &log)
{
  Table rows = {{"body", "extents", "volume", "mass"}};
  for (unsigned int d = 0; d < sizes.size(); ++d) {
    const double density = density_of(scene, model.domains[d]->material.name);
    rows.push_back({model.domains[d]->name, extent(sizes[d]), five_digits(sizes[d].volume),
                    density > 0 ? five_digits(density * sizes[d].volume) : "no Density"});
  }
  log.table(rows);
}

template <int dim>
void tell_boundaries(const Model<dim> &model, const std::vector<BodySize<dim>> &sizes, const SceneText &text,
                     Log &log)
{
  Table rows = {{"boundary", "name", "area", "conditions", "interfaces"}};
  for (unsigned int d = 0; d < sizes.size(); ++d) {
    const Domain<dim> &body = *model.domains[d];
    for (const auto &[id, area] : sizes[d].areas) {
      std::vector<std::string> conditions, interfaces;
      for (const auto &condition : body.conditions())
        if (condition->boundary_ids.count(id) > 0)
          conditions.push_back(condition->name);
      for (const auto &interface : model.interfaces)
        for (const auto &side : interface->sides)
          if (side.domain == &body && side.boundary_ids.count(id) > 0)
            interfaces.push_back(interface->name);
      rows.push_back({body.name + " : " + std::to_string(id),
                      names_of_boundary(id, text.boundary_names(body.name)), five_digits(area),
                      conditions.empty() ? "-" : comma_separated(conditions),
                      interfaces.empty() ? "-" : comma_separated(interfaces)});
    }
  }
  log.table(rows);
}

template <int dim>
void tell_conditions(const Model<dim> &model, Log &log)
{
  Table rows = {{"condition", "type", "field", "faces", "prescribed unknowns", "toggle"}};
  for (const auto &body : model.domains)
    for (const auto &condition : body->conditions()) {
      const ActingOn acting = find_what_it_acts_on(*body, *condition, model.communicator);
      rows.push_back({body->name + " / " + condition->name, condition->section.peek("Type"),
                      condition->field.name, std::to_string(acting.n_faces),
                      std::to_string(acting.n_prescribed),
                      condition->toggle_name().empty() ? "-" : condition->toggle_name()});
    }
  if (rows.size() > 1)
    log.table(rows);
}

template <int dim>
bool has_toggles_at_all(const Model<dim> &model)
{
  return std::any_of(model.interfaces.begin(), model.interfaces.end(),
                     [](const auto &interface) { return interface->has_toggle(); }) ||
         std::any_of(model.domains.begin(), model.domains.end(), [](const auto &body) {
           return std::any_of(body->conditions().begin(), body->conditions().end(),
                              [](const auto &condition) { return !condition->toggle_name().empty(); });
         });
}

/// Each motion once, with the first time at which nothing holds it.
template <int dim>
void add_notes_on_motions(const Model<dim> &model, const std::vector<double> &times, Notes &notes)
{
  std::set<std::string> told;
  for (const FreeMotion &motion : find_free_motions(model, {}))
    if (told.insert(motion.in_words()).second)
      notes.add(of_free_motion("nothing holds " + motion.in_words() +
                               ". Prescribe a part of it, or add a symmetry, a spring or a point support"));
  if (!has_toggles_at_all(model))
    return;
  for (const double t : times)
    for (const FreeMotion &motion : find_free_motions(model, t))
      if (told.insert(motion.in_words()).second)
        notes.add(of_free_motion("at t = " + five_digits(t) + ", where a toggle is off, nothing holds " +
                                 motion.in_words() + ": let a toggle be active then, or hold it otherwise"));
}

} // namespace

template <int dim>
void rehearse(const Model<dim> &model, const SceneText &text, const Section &scene,
              const std::vector<double> &times, Log &log, Notes &notes)
{
  std::vector<BodySize<dim>> sizes;
  for (const auto &body : model.domains)
    sizes.push_back(measure_body(*body, model.communicator));
  tell_bodies(model, sizes, scene, log);
  tell_boundaries(model, sizes, text, log);
  tell_conditions(model, log);
  add_notes_on_motions(model, times, notes);
}

template void rehearse(const Model<2> &, const SceneText &, const Section &, const std::vector<double> &,
                       Log &, Notes &);
template void rehearse(const Model<3> &, const SceneText &, const Section &, const std::vector<double> &,
                       Log &, Notes &);

} // namespace dovetail
