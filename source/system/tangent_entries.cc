// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/tangent_entries.h>

#include <dovetail/compatibility.h>
#include <dovetail/interface/tie_operator.h>

#include <deal.II/base/table.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>

namespace dovetail {

template <int dim>
std::vector<unsigned int> merge_repeated(const Interface<dim> &interface,
                                         std::vector<dealii::types::global_dof_index> &dofs)
{
  if (interface.sides[source].domain != interface.sides[destination].domain)
    return {};
  std::vector<dealii::types::global_dof_index> sorted = dofs;
  std::sort(sorted.begin(), sorted.end());
  const auto end = std::unique(sorted.begin(), sorted.end());
  if (end == sorted.end())
    return {};
  sorted.erase(end, sorted.end());
  std::vector<unsigned int> position;
  for (const auto dof : dofs)
    position.push_back(std::lower_bound(sorted.begin(), sorted.end(), dof) - sorted.begin());
  dofs = sorted;
  return position;
}

template <int dim>
bool TangentEntries<dim>::exist(const std::string &field) const
{
  const auto groups = model.field_groups();
  for (unsigned int g = 0; g < groups_with_entries.size(); ++g)
    if (!groups_with_entries[g] && std::find(groups[g].begin(), groups[g].end(), field) != groups[g].end())
      return false;
  return true;
}

template <int dim>
bool TangentEntries<dim>::are_products(const Interface<dim> &interface, const TiedField &field) const
{
  return form == Form::direct && TieOperator<dim>::is_possible(interface, field) &&
         !exist(field.names[source]);
}

template <int dim>
bool TangentEntries<dim>::exist(const Interface<dim> &interface, const unsigned int row,
                                const unsigned int column) const
{
  if (!(form == Form::direct ? interface.couples(row, column) : interface.couples(column, row)))
    return false;
  const auto field_of = [&](const unsigned int i) -> const Field & {
    const unsigned int n = interface.components[source].size();
    const auto &side = interface.sides[i < n ? source : destination];
    const unsigned int c = i < n ? interface.components[source][i] : interface.components[destination][i - n];
    const auto &fields = side.domain->fields();
    return *std::find_if(fields.begin(), fields.end(),
                         [c](const Field &field) { return field.has_component(c); });
  };
  const std::string &name = field_of(row).name, &by = field_of(column).name;
  return !stages.is_left_out(name, by) &&
         (name != by ||
          std::none_of(interface.fields.begin(), interface.fields.end(), [&](const auto &field) {
            return field.names[source] == name && are_products(interface, field);
          }));
}

template <int dim>
bool TangentEntries<dim>::exist(const Interface<dim> &interface) const
{
  const unsigned int n = interface.components[source].size() + interface.components[destination].size();
  for (unsigned int row = 0; row < n; ++row)
    for (unsigned int column = 0; column < n; ++column)
      if (exist(interface, row, column))
        return true;
  return false;
}

/// Whether the equations of one field of a domain have entries by another one.
template <int dim>
bool TangentEntries<dim>::depends(const Domain<dim> &domain, const unsigned int field,
                                  const unsigned int by) const
{
  const std::string &name = domain.fields()[field].name, &name_by = domain.fields()[by].name;
  return (form == Form::direct ? domain.material.depends(field, by) : domain.material.depends(by, field)) &&
         !(field == by && !exist(name)) && !stages.is_left_out(name, name_by);
}

namespace {

/// Those of a cell, of one field.
template <int dim>
struct UnknownsOfField
{
  UnknownsOfField(const Domain<dim> &domain, const Field &field)
      : begin(domain.layout().first(field.first_component)),
        end(domain.layout().first(field.first_component + field.n_components))
  {
  }
  const unsigned int begin, end;
};

template <int dim>
void couple(const Domain<dim> &domain, const Field &field, const Field &by, const bool value,
            dealii::Table<2, bool> &couplings)
{
  const UnknownsOfField<dim> rows(domain, field), columns(domain, by);
  for (unsigned int i = rows.begin; i < rows.end; ++i)
    for (unsigned int j = columns.begin; j < columns.end; ++j)
      couplings(i, j) = value;
}

} // namespace

template <int dim>
void TangentEntries<dim>::leave_out(const Domain<dim> &domain, dealii::Table<2, bool> &couplings) const
{
  for (const Field &field : domain.fields())
    for (const Field &by : domain.fields())
      if (stages.is_left_out(field.name, by.name))
        couple(domain, field, by, false, couplings);
}

template <int dim>
void TangentEntries<dim>::add(const CellTerms<dim> &terms, const dealii::AffineConstraints<double> &lines,
                              dealii::DynamicSparsityPattern &pattern) const
{
  const Domain<dim> &domain = terms.body();
  const auto &fields = domain.fields();
  dealii::Table<2, bool> couplings(domain.dofs_per_cell(), domain.dofs_per_cell());
  bool all_couple = true, any_couples = false, has_all_entries = true;
  for (unsigned int f = 0; f < fields.size(); ++f) {
    for (unsigned int g = 0; g < fields.size(); ++g) {
      const bool depends_here = depends(domain, f, g);
      all_couple = all_couple && depends_here;
      any_couples = any_couples || depends_here;
      if (depends_here)
        couple(domain, fields[f], fields[g], true, couplings);
    }
    const bool has_entries = exist(fields[f].name);
    has_all_entries = has_all_entries && has_entries;
    if (!has_entries && terms.lumps_storage()) {
      any_couples = true;
      const UnknownsOfField<dim> unknowns(domain, fields[f]);
      for (unsigned int i = unknowns.begin; i < unknowns.end; ++i)
        couplings(i, i) = true;
    }
  }
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const bool has_boundary_terms = !has_all_entries && terms.has_boundary_tangent(cell);
      if (!any_couples && !has_boundary_terms)
        continue;
      domain.cell_dofs(cell, dofs);
      if (all_couple)
        lines.add_entries_local_to_global(dofs, pattern, false);
      else if (has_boundary_terms) {
        dealii::Table<2, bool> with_boundary(couplings);
        terms.add_boundary_couplings(cell, with_boundary);
        leave_out(domain, with_boundary);
        lines.add_entries_local_to_global(dofs, pattern, false, with_boundary);
      } else
        lines.add_entries_local_to_global(dofs, pattern, false, couplings);
    }
}

/// By local unknown of both sides.
template <int dim>
dealii::Table<2, bool> TangentEntries<dim>::couplings_of_components(const Interface<dim> &interface) const
{
  std::vector<unsigned int> component; // of each local unknown, counted over both sides
  for (const unsigned int side : {source, destination})
    for (unsigned int k = 0; k < interface.components[side].size(); ++k)
      component.insert(component.end(),
                       interface.sides[side].domain->layout().n_nodes(interface.components[side][k]),
                       k + (side == source ? 0 : interface.components[source].size()));
  const unsigned int n = component.size(), n_components = component.back() + 1;
  dealii::Table<2, bool> of_components(n_components, n_components), depends(n, n);
  for (unsigned int row = 0; row < n_components; ++row)
    for (unsigned int column = 0; column < n_components; ++column)
      of_components(row, column) = exist(interface, row, column);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j)
      depends(i, j) = of_components(component[i], component[j]);
  return depends;
}

/// The two cells of a group couple by the jump alone, unless the tie couples their fluxes, too: an unknown
/// that is not in the jump then meets only those of the other cell that are, which leaves most of a cell of
/// high degree out. Likewise within a cell, unless the tie adds second derivatives of its flux; they belong
/// here although the cell couples all its unknowns itself, because this rank may not own it.
template <int dim>
void TangentEntries<dim>::add(const Interface<dim> &interface, const dealii::AffineConstraints<double> &lines,
                              dealii::DynamicSparsityPattern &pattern) const
{
  const dealii::Table<2, bool> depends = couplings_of_components(interface);
  const unsigned int n = depends.size(0);
  const bool by_flux = interface.tie().parts().point_terms->couples_fluxes();
  const bool by_inside = interface.tie().parts().point_terms->couples_insides(interface);
  const auto is_of_source = [&](const unsigned int i) { return i < interface.n_local(source); };

  std::vector<dealii::types::global_dof_index> dofs;
  dealii::Table<2, bool> couples(n, n);
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    const std::vector<bool> in_jump =
        by_flux ? std::vector<bool>(n, true) : interface.unknowns_in_jump(group);
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        couples(i, j) =
            depends(i, j) && (in_jump[i] || in_jump[j] || (by_inside && is_of_source(i) == is_of_source(j)));
    if (const auto position = merge_repeated(interface, dofs); !position.empty()) {
      dealii::Table<2, bool> merged(dofs.size(), dofs.size());
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          merged(position[i], position[j]) = merged(position[i], position[j]) || couples(i, j);
      lines.add_entries_local_to_global(dofs, pattern, false, merged);
    } else
      lines.add_entries_local_to_global(dofs, pattern, false, couples);
  }
}

template <int dim>
dealii::DynamicSparsityPattern TangentEntries<dim>::pattern(const double t,
                                                            const TermsOfDomains &terms_of_domains,
                                                            const dealii::AffineConstraints<double> &lines,
                                                            const dealii::IndexSet &relevant) const
{
  dealii::DynamicSparsityPattern pattern(relevant);
  for (const auto &terms : terms_of_domains)
    add(*terms, lines, pattern);
  for (const auto &interface : model.interfaces) {
    const TieParts<dim> parts = interface->tie().parts();
    if (interface->is_active(t)) {
      if (parts.point_terms != nullptr)
        add(*interface, lines, pattern);
      for (unsigned int i = 0; parts.multipliers != nullptr && i < parts.multipliers->n_terms(); ++i)
        lines.add_entries_local_to_global(parts.multipliers->term_dofs(i), pattern, false);
    } else
      for_each_multiplier(*interface, [&](const auto dof) { pattern.add(dof, dof); });
  }
  for (const Block &block : model.numbering->blocks()) // where a pressure that is not known may be held
    if (block.is_of_pressure() && block.owned.n_elements() > 0) {
      const auto first = block.begin + block.owned.nth_index_in_set(0);
      pattern.add(first, first);
    }
  dealii::SparsityTools::distribute_sparsity_pattern(pattern, model.numbering->owned, model.communicator,
                                                     relevant);
  return pattern;
}

template class TangentEntries<2>;
template class TangentEntries<3>;

template std::vector<unsigned int> merge_repeated<2>(const Interface<2> &,
                                                     std::vector<dealii::types::global_dof_index> &);
template std::vector<unsigned int> merge_repeated<3>(const Interface<3> &,
                                                     std::vector<dealii::types::global_dof_index> &);

} // namespace dovetail
