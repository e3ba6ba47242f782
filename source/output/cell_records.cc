// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/bytes.h>
#include <dovetail/output/cell_records.h>

#include <deal.II/base/mpi.h>
#include <deal.II/grid/cell_id.h>

#include <unordered_map>

namespace dovetail {

namespace {

template <typename Id>
Id next_id(NumbersOfBytes &bytes)
{
  Id id;
  for (auto &word : id)
    word = bytes.next<std::uint32_t>();
  return id;
}

template <typename Id>
void add_id(const Id &id, std::string &bytes)
{
  for (const auto word : id)
    add_number<std::uint32_t>(word, bytes);
}

} // namespace

NumbersOfUnknowns NumbersOfUnknowns::sent_to_owners(const Numbering &numbering,
                                                    const MPI_Comm &communicator) const
{
  std::map<unsigned int, NumbersOfUnknowns> messages;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    NumbersOfUnknowns &message = messages[numbering.owner(unknowns[i])];
    message.n = n;
    message.unknowns.push_back(unknowns[i]);
    message.numbers.insert(message.numbers.end(), numbers.begin() + i * n, numbers.begin() + (i + 1) * n);
  }
  NumbersOfUnknowns own;
  own.n = n;
  for (const auto &[rank, message] : dealii::Utilities::MPI::some_to_some(communicator, messages)) {
    own.unknowns.insert(own.unknowns.end(), message.unknowns.begin(), message.unknowns.end());
    own.numbers.insert(own.numbers.end(), message.numbers.begin(), message.numbers.end());
  }
  return own;
}

template <int dim>
CellRecords<dim>::CellRecords(const Domain<dim> &domain) : domain(domain)
{
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned())
      cells[cell->id().template to_binary<dim>()] = cell;
}

template <int dim>
std::string CellRecords<dim>::pack(const NumbersOfUnknowns &own) const
{
  std::unordered_map<dealii::types::global_dof_index, std::size_t> place;
  for (std::size_t i = 0; i < own.unknowns.size(); ++i)
    place[own.unknowns[i]] = i;
  std::string bytes;
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &[id, cell] : cells) {
    domain.cell_dofs(cell, dofs);
    std::uint16_t count = 0;
    std::string entries;
    for (std::uint16_t i = 0; i < dofs.size(); ++i)
      if (const auto found = place.find(dofs[i]); found != place.end()) {
        ++count;
        add_number(i, entries);
        for (unsigned int j = 0; j < own.n; ++j)
          add_number(own.numbers[found->second * own.n + j], entries);
        place.erase(found);
      }
    if (count > 0) {
      add_id(id, bytes);
      add_number(count, bytes);
      bytes += entries;
    }
  }
  Assert(place.empty(), dealii::ExcMessage("An unknown is in no cell of its owner."));
  return bytes;
}

template <int dim>
void CellRecords<dim>::unpack(const std::string &part, NumbersOfUnknowns &found) const
{
  std::vector<dealii::types::global_dof_index> dofs;
  for (NumbersOfBytes bytes(part); !bytes.is_at_end();) {
    const auto cell = cells.find(next_id<Id>(bytes));
    if (cell != cells.end())
      domain.cell_dofs(cell->second, dofs);
    const auto count = bytes.next<std::uint16_t>();
    for (unsigned int entry = 0; entry < count; ++entry) {
      const auto i = bytes.next<std::uint16_t>();
      const bool is_here = cell != cells.end() && i < dofs.size();
      if (is_here)
        found.unknowns.push_back(dofs[i]);
      for (unsigned int j = 0; j < found.n; ++j) {
        const auto number = bytes.next<double>();
        if (is_here)
          found.numbers.push_back(number);
      }
    }
  }
}

template <int dim>
std::string CellRecords<dim>::pack(const NumbersOfCells &own) const
{
  std::string bytes;
  for (const auto &[id, cell] : cells) {
    const std::vector<double> &numbers = own[cell->active_cell_index()];
    if (numbers.empty())
      continue;
    add_id(id, bytes);
    add_number<std::uint32_t>(numbers.size(), bytes);
    for (const double number : numbers)
      add_number(number, bytes);
  }
  return bytes;
}

template <int dim>
void CellRecords<dim>::unpack(const std::string &part, NumbersOfCells &found) const
{
  for (NumbersOfBytes bytes(part); !bytes.is_at_end();) {
    const auto cell = cells.find(next_id<Id>(bytes));
    std::vector<double> numbers(bytes.next<std::uint32_t>());
    for (double &number : numbers)
      number = bytes.next<double>();
    if (cell != cells.end())
      found[cell->second->active_cell_index()] = numbers;
  }
}

template class CellRecords<2>;
template class CellRecords<3>;

} // namespace dovetail
