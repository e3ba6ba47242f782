// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/mesh_size.h>
#include <dovetail/domain/numbering.h>

#include <deal.II/base/mpi.h>
#include <deal.II/dofs/dof_tools.h>

#include <algorithm>

namespace dovetail {

template <int dim>
Numbering::Numbering(const std::vector<std::unique_ptr<Domain<dim>>> &domains, const MPI_Comm &communicator)
{
  dealii::types::global_dof_index n_dofs = 0;
  for (unsigned int d = 0; d < domains.size(); ++d) {
    Domain<dim> &domain = *domains[d];
    check_total(double(n_dofs) + domain.dof_handler().n_dofs());
    domain.number_from(n_dofs);
    const auto &sizes = domain.n_dofs_of_fields();
    const auto &owned_by_domain = domain.dof_handler().locally_owned_dofs();
    dealii::types::global_dof_index begin = 0;
    for (unsigned int f = 0; f < domain.fields().size(); ++f) {
      const auto part = owned_by_domain.get_view(begin, begin + sizes[f]);
      std::vector<dealii::types::global_dof_index> first_of_rank = {0};
      for (const auto count : dealii::Utilities::MPI::all_gather(communicator, part.n_elements()))
        first_of_rank.push_back(first_of_rank.back() + count);
      const Field &field = domain.fields()[f];
      all_blocks.push_back({domain.name, field.name, false, field.is_multiplier, d, f, n_dofs + begin,
                            n_dofs + begin + sizes[f], part, first_of_rank});
      begin += sizes[f];
    }
    n_dofs += begin;
  }

  owned.set_size(n_dofs);
  relevant.set_size(n_dofs);
  for (const auto &domain : domains) {
    const dealii::IndexSet relevant_to_domain =
        dealii::DoFTools::extract_locally_relevant_dofs(domain->dof_handler());
    owned.add_indices(domain->dof_handler().locally_owned_dofs(), domain->first_dof());
    relevant.add_indices(relevant_to_domain, domain->first_dof());
  }
  owned.compress();
  relevant.compress();
}

dealii::types::global_dof_index Numbering::add_multipliers(const std::string &interface,
                                                           const std::string &field,
                                                           const dealii::types::global_dof_index n_own,
                                                           const MPI_Comm &communicator)
{
  std::vector<dealii::types::global_dof_index> first_of_rank = {0};
  for (const auto count : dealii::Utilities::MPI::all_gather(communicator, n_own))
    first_of_rank.push_back(first_of_rank.back() + count);
  const auto begin = owned.size(), n = first_of_rank.back();
  check_total(double(begin) + n);
  const auto first = first_of_rank[dealii::Utilities::MPI::this_mpi_process(communicator)];
  if (n == 0)
    return begin;
  dealii::IndexSet block_set(n);
  block_set.add_range(first, first + n_own);
  all_blocks.push_back({interface, field, true, true, 0, 0, begin, begin + n, block_set, first_of_rank});
  for (dealii::IndexSet *set : {&owned, &relevant}) {
    dealii::IndexSet larger(begin + n);
    larger.add_indices(*set);
    larger.add_indices(block_set, begin);
    larger.compress();
    *set = larger;
  }
  return begin + first;
}

unsigned int Numbering::block_of(const dealii::types::global_dof_index dof) const
{
  return std::upper_bound(all_blocks.begin(), all_blocks.end(), dof,
                          [](const auto index, const Block &block) { return index < block.end; }) -
         all_blocks.begin();
}

unsigned int Numbering::owner(const dealii::types::global_dof_index dof) const
{
  const Block &block = all_blocks[block_of(dof)];
  const auto after =
      std::upper_bound(block.first_of_rank.begin(), block.first_of_rank.end(), dof - block.begin);
  return after - block.first_of_rank.begin() - 1;
}

std::vector<dealii::IndexSet> Numbering::split(const dealii::IndexSet &set) const
{
  std::vector<dealii::IndexSet> parts;
  for (const Block &block : all_blocks)
    parts.push_back(set.get_view(block.begin, block.end));
  return parts;
}

template Numbering::Numbering(const std::vector<std::unique_ptr<Domain<2>>> &, const MPI_Comm &);
template Numbering::Numbering(const std::vector<std::unique_ptr<Domain<3>>> &, const MPI_Comm &);

} // namespace dovetail
