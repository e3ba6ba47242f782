// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/ghost_exchange.h>

#include <algorithm>

namespace dovetail {

GhostExchange::GhostExchange(const std::vector<dealii::IndexSet> &owned,
                             const std::vector<dealii::IndexSet> &relevant_sets,
                             const std::function<unsigned int(unsigned int, Index)> &owner,
                             const MPI_Comm &communicator)
    : owned(owned), relevant(relevant_sets), communicator(communicator)
{
  std::vector<Index> sizes;
  std::map<unsigned int, std::vector<std::pair<unsigned int, Index>>> asked; // by rank: block, index
  for (unsigned int b = 0; b < owned.size(); ++b) {
    sizes.push_back(owned[b].size());
    relevant[b].add_indices(owned[b]);
    first_owned.push_back(
        owned[b].n_elements() > 0 ? relevant[b].index_within_set(owned[b].nth_index_in_set(0)) : 0);
    unsigned int place = 0;
    for (const Index index : relevant[b]) {
      if (!owned[b].is_element(index)) {
        const unsigned int rank = owner(b, index);
        asked[rank].emplace_back(b, index);
        ghosts[rank].push_back({b, place});
      }
      ++place;
    }
  }
  blocks.reinit(sizes);
  for (const auto &[rank, unknowns] : dealii::Utilities::MPI::some_to_some(communicator, asked))
    for (const auto &[b, index] : unknowns)
      given[rank].push_back({b, static_cast<unsigned int>(relevant[b].index_within_set(index))});
}

GhostExchange::Vector GhostExchange::ghosted_vector() const
{
  return Vector(owned, relevant, communicator);
}

void GhostExchange::update(Vector &ghosted, const Vector &owned_values) const
{
  std::vector<double *> values;
  for (unsigned int b = 0; b < owned.size(); ++b) {
    const Epetra_MultiVector &of_block = owned_values.block(b).trilinos_vector();
    Epetra_MultiVector &result = ghosted.block(b).trilinos_vector();
    AssertThrow(of_block.MyLength() == static_cast<int>(owned[b].n_elements()) &&
                    result.MyLength() == static_cast<int>(relevant[b].n_elements()),
                dealii::ExcMessage("vectors of other unknowns"));
    values.push_back(result[0]);
    std::copy_n(of_block[0], of_block.MyLength(), values[b] + first_owned[b]);
  }
  exchange_numbers(values, given, ghosts, communicator,
                   [](double &value, const double received) { value = received; });
}

void SharedSums::begin(const GhostExchange &of_unknowns)
{
  exchange = &of_unknowns;
  values.resize(exchange->relevant.size());
  for (unsigned int b = 0; b < values.size(); ++b)
    values[b].assign(exchange->relevant[b].n_elements(), 0.);
}

double &SharedSums::operator()(const Index row)
{
  const auto [block, index] = exchange->blocks.global_to_local(row);
  const auto place = exchange->relevant[block].index_within_set(index);
  AssertThrow(place < values[block].size(), dealii::ExcMessage("a row that is not relevant here"));
  return values[block][place];
}

void SharedSums::finish(GhostExchange::Vector &owned)
{
  std::vector<double *> pointers;
  for (std::vector<double> &of_block : values)
    pointers.push_back(of_block.data());
  exchange_numbers(pointers, exchange->ghosts, exchange->given, exchange->communicator,
                   [](double &sum, const double received) { sum += received; });
  for (unsigned int b = 0; b < values.size(); ++b) {
    Epetra_MultiVector &result = owned.block(b).trilinos_vector();
    std::copy_n(owned_rows(b), result.MyLength(), result[0]);
  }
}

} // namespace dovetail
