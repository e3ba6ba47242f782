// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/local_to_global.h>

#include <algorithm>

namespace dovetail {

template <int dim>
void LocalToGlobal<dim>::begin_domain(const unsigned int domain, const bool have_tangents)
{
  const Shares &shares = stages.of_cells(domain);
  positions[domain].resize(shares.size());
  if (!have_tangents || entries.form != Form::direct)
    return;
  const auto &fields = model.domains[domain]->fields();
  for (unsigned int s = 0; s < shares.size(); ++s)
    if (stages.asks_tangent(shares[s]) &&
        (shares.size() == 1 ||
         std::any_of(shares[s].fields.begin(), shares[s].fields.end(),
                     [&](const unsigned int f) { return entries.exist(fields[f].name); }))) {
      auto &of_share = positions[domain][s];
      if (of_share)
        of_share->keep();
      else
        of_share = std::make_unique<KeptPositions<dim>>(*model.domains[domain], shares[s].fields, matrix);
    }
}

template <int dim>
void LocalToGlobal<dim>::prefetch(const unsigned int domain, const unsigned int cell_index) const
{
  for (unsigned int s = 0; s < positions[domain].size(); ++s)
    if (positions[domain][s] && stages.asks_tangent(stages.of_cells(domain)[s]))
      positions[domain][s]->prefetch(cell_index);
}

/// Calls @p add with the number of each share, its unknowns, its residual and its tangent.
template <int dim>
template <typename Add>
void LocalToGlobal<dim>::add_shares(const Shares &shares, const Dofs &dofs,
                                    const std::vector<double> &residual,
                                    const dealii::FullMatrix<double> *tangent, const Add &add)
{
  for (unsigned int s = 0; s < shares.size(); ++s) {
    if (!stages.asks_residual(shares[s]))
      continue;
    const bool has_tangent = tangent != nullptr && stages.asks_tangent(shares[s]);
    if (shares.size() == 1) {
      add(s, dofs, residual, has_tangent ? tangent : nullptr);
      continue;
    }
    const std::vector<unsigned int> &unknowns = shares[s].unknowns;
    const unsigned int n = unknowns.size();
    residual_of_share.resize(n);
    dofs_of_share.resize(n);
    for (unsigned int i = 0; i < n; ++i) {
      residual_of_share[i] = residual[unknowns[i]];
      dofs_of_share[i] = dofs[unknowns[i]];
    }
    if (has_tangent && tangent_of_share.m() != n)
      tangent_of_share.reinit(n, n, true);
    for (unsigned int i = 0; has_tangent && i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        tangent_of_share(i, j) = (*tangent)(unknowns[i], unknowns[j]);
    add(s, dofs_of_share, residual_of_share, has_tangent ? &tangent_of_share : nullptr);
  }
}

template <int dim>
void LocalToGlobal<dim>::add(const unsigned int domain, const unsigned int cell_index, const Dofs &dofs,
                             const std::vector<double> &residual, const dealii::FullMatrix<double> *tangent)
{
  add_shares(stages.of_cells(domain), dofs, residual, tangent,
             [&](const unsigned int s, const Dofs &dofs_here, const std::vector<double> &residual_here,
                 const dealii::FullMatrix<double> *tangent_here) {
               if (tangent_here == nullptr || !positions[domain][s] ||
                   !positions[domain][s]->add(cell_index, dofs_here, constraints.of_update(), *tangent_here,
                                              residual_here, right_hand_side))
                 distribute(dofs_here, residual_here, tangent_here);
             });
}

template <int dim>
void LocalToGlobal<dim>::add(const Shares &shares, const Dofs &dofs, const std::vector<double> &residual,
                             const dealii::FullMatrix<double> *tangent)
{
  add_shares(shares, dofs, residual, tangent,
             [&](unsigned int, const Dofs &dofs_here, const std::vector<double> &residual_here,
                 const dealii::FullMatrix<double> *tangent_here) {
               distribute(dofs_here, residual_here, tangent_here);
             });
}

template <int dim>
void LocalToGlobal<dim>::distribute(const Dofs &dofs, const std::vector<double> &residual,
                                    const dealii::FullMatrix<double> *tangent)
{
  negative_residual.reinit(residual.size(), true);
  for (unsigned int i = 0; i < residual.size(); ++i)
    negative_residual[i] = -residual[i];
  const dealii::AffineConstraints<double> &lines = constraints.of_update();
  if (tangent == nullptr)
    lines.distribute_local_to_global(negative_residual, dofs, right_hand_side);
  else if (entries.form == Form::transposed) {
    transpose.reinit(residual.size(), residual.size(), true);
    transpose.copy_transposed(*tangent);
    distribute_local_to_global(lines, transpose, negative_residual, dofs, matrix, right_hand_side);
  } else
    distribute_local_to_global(lines, *tangent, negative_residual, dofs, matrix, right_hand_side);
}

template class LocalToGlobal<2>;
template class LocalToGlobal<3>;

} // namespace dovetail
