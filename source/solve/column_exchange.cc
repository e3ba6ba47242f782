// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/column_exchange.h>

#include <Epetra_MpiComm.h>

#include <algorithm>

namespace dovetail {

namespace {

std::vector<int> columns_of_other_ranks(const Epetra_CrsMatrix &A)
{
  std::vector<int> others;
  for (int k = 0; k < A.NumMyCols(); ++k)
    if (A.DomainMap().LID(A.GCID(k)) < 0)
      others.push_back(A.GCID(k));
  return others;
}

} // namespace

ColumnExchange::ColumnExchange(const Epetra_CrsMatrix &A)
    : ColumnExchange(A.DomainMap(), columns_of_other_ranks(A))
{
}

ColumnExchange::ColumnExchange(const Epetra_Map &own, const std::vector<int> &others)
    : own_columns(own), communicator(dynamic_cast<const Epetra_MpiComm &>(own.Comm()).Comm())
{
  auto map = std::make_shared<Epetra_Map>(-1, static_cast<int>(others.size()), others.data(), 0, own.Comm());
  if (map->NumGlobalElements() == 0)
    return;
  other_columns = std::move(map);
  const unsigned int n = others.size();
  std::vector<int> ranks(n), indices(n);
  own_columns.RemoteIDList(n, others.data(), ranks.data(), indices.data());
  Partners asked;
  for (unsigned int i = 0; i < n; ++i) {
    asked[ranks[i]].push_back({0, static_cast<unsigned int>(indices[i])});
    taken[ranks[i]].push_back({0, own_columns.NumMyElements() + i});
  }
  given = find_who_asks(asked, communicator);
}

unsigned int ColumnExchange::n_columns() const
{
  return own_columns.NumMyElements() + (other_columns ? other_columns->NumMyElements() : 0);
}

int ColumnExchange::number(const int global) const
{
  if (const int own = own_columns.LID(global); own >= 0)
    return own;
  const int other = other_columns ? other_columns->LID(global) : -1;
  return other < 0 ? other : own_columns.NumMyElements() + other;
}

int ColumnExchange::global(const int number) const
{
  const int n_own = own_columns.NumMyElements();
  return number < n_own ? own_columns.GID(number) : other_columns->GID(number - n_own);
}

const double *ColumnExchange::of_columns(const Epetra_Vector &x, std::vector<double> &buffer) const
{
  if (!other_columns)
    return x.Values();
  buffer.resize(n_columns());
  std::copy_n(x.Values(), x.MyLength(), buffer.data());
  exchange_numbers({buffer.data()}, given, taken, communicator,
                   [](double &value, const double received) { value = received; });
  return buffer.data();
}

void ColumnExchange::add_up(std::vector<double> &sums, Epetra_Vector &y) const
{
  exchange_numbers({sums.data()}, taken, given, communicator,
                   [](double &sum, const double received) { sum += received; });
  std::copy_n(sums.begin(), y.MyLength(), y.Values());
}

} // namespace dovetail
