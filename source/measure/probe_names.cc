// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/probe_names.h>

namespace dovetail {

namespace {

/// Of a vector or of a tensor row by row; a number of its own has no name.
std::vector<std::string> names_of_components(const unsigned int n, const bool is_axisymmetric)
{
  const std::string axes = is_axisymmetric ? "rzt" : "xyz";
  std::vector<std::string> names;
  for (unsigned int i = 0; i < n; ++i)
    if (n == 1)
      names.emplace_back();
    else if (n <= 3)
      names.emplace_back(1, axes[i]);
    else if (n == 9)
      names.push_back({axes[i / 3], axes[i % 3]});
    else
      names.push_back(std::to_string(i));
  return names;
}

/// In SI; empty if it is not known.
template <int dim>
std::string unit_of(const typename Probes<dim>::Probe &probe)
{
  std::string unit;
  if (probe.field)
    unit = probe.X || probe.reduce ? units_of_field(probe.field->name).value
                                   : units_of_field(probe.field->name).resultant;
  else
    unit = QuantityCatalogue<dim>::find(probe.section->peek("Quantity"), *probe.section, "Quantity").unit();
  if (unit.empty() || probe.reduce != Reduce::integral)
    return unit;
  return unit + (probe.region.boundary_ids.empty() ? " m^3" : " m^2");
}

} // namespace

namespace {

template <int dim>
std::vector<std::string> names_without_unit(const typename Probes<dim>::Probe &probe)
{
  std::vector<std::string> names;
  const auto arrays = probe.quantity->arrays();
  for (const auto &array : arrays)
    for (const std::string &component :
         names_of_components(array.n_components, probe.region.domain->measure.is_axisymmetric()))
      names.push_back(probe.name + (arrays.size() > 1 ? " " + array.name : "") +
                      (component.empty() ? "" : " " + component));
  return names;
}

} // namespace

template <int dim>
std::string in_brackets(const Probes<dim> &probes, const std::string &unit)
{
  const std::string in_units = probes.units() ? probes.units()->of(unit) : "";
  return in_units.empty() ? "" : " [" + in_units + "]";
}

UnitsOfField units_of_field(const std::string &field)
{
  if (field == "displacement")
    return {"m", "Pa", "N"};
  if (field == "temperature")
    return {"K", "W/m^2", "W"};
  if (field == "pressure")
    return {"Pa", "", ""};
  return {};
}

template <int dim>
std::vector<NamesOfProbe> names_of_columns(const Probes<dim> &probes)
{
  std::vector<NamesOfProbe> result;
  for (const auto &probe : probes.all()) {
    NamesOfProbe names;
    const bool has_places = probe.reduce == Reduce::minimum || probe.reduce == Reduce::maximum;
    for (const std::string &name : names_without_unit<dim>(probe)) {
      names.numbers.push_back(name + in_brackets(probes, unit_of<dim>(probe)));
      for (unsigned int d = 0; has_places && d < dim; ++d)
        names.places.push_back(name + " at " +
                               (probe.region.domain->measure.is_axisymmetric() ? "rz" : "xyz")[d] +
                               in_brackets(probes, "m"));
    }
    result.push_back(names);
  }
  return result;
}

template std::vector<NamesOfProbe> names_of_columns(const Probes<2> &);
template std::vector<NamesOfProbe> names_of_columns(const Probes<3> &);
template std::string in_brackets(const Probes<2> &, const std::string &);
template std::string in_brackets(const Probes<3> &, const std::string &);

} // namespace dovetail
