// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/exchange.h>

namespace dovetail {

using Index = dealii::types::global_dof_index;

std::map<Index, unsigned int> owners(const std::set<Index> &dofs, const Index first_dof,
                                     const dealii::IndexSet &owned, const MPI_Comm &communicator)
{
  dealii::IndexSet asked(owned.size());
  for (const Index dof : dofs)
    asked.add_index(dof - first_dof);
  asked.compress();
  const bool are_own = (asked & owned).n_elements() == asked.n_elements();
  std::vector<unsigned int> ranks(asked.n_elements(), dealii::Utilities::MPI::this_mpi_process(communicator));
  if (dealii::Utilities::MPI::max(are_own ? 0 : 1, communicator) > 0)
    ranks = dealii::Utilities::MPI::compute_index_owner(owned, asked, communicator);
  std::map<Index, unsigned int> result;
  unsigned int i = 0;
  for (const Index dof : dofs)
    result[dof] = ranks[i++];
  return result;
}

RankMap<std::vector<char>> exchange_bytes(const RankMap<std::vector<char>> &bytes,
                                          const MPI_Comm &communicator, InterfaceWork &work)
{
  for (const auto &message : bytes) {
    ++work.messages;
    work.bytes += message.second.size();
  }
  if (dealii::Utilities::MPI::max(bytes.empty() ? 0 : 1, communicator) == 0)
    return {};
  return dealii::Utilities::MPI::some_to_some(communicator, bytes);
}

} // namespace dovetail
