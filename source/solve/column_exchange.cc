// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/column_exchange.h>

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

ColumnExchange::ColumnExchange(const Epetra_Map &own, const std::vector<int> &others) : own_columns(own)
{
  auto map = std::make_shared<Epetra_Map>(-1, static_cast<int>(others.size()), others.data(), 0, own.Comm());
  if (map->NumGlobalElements() == 0)
    return;
  other_columns = std::move(map);
  import = std::make_shared<Epetra_Import>(*other_columns, own_columns);
}

unsigned int ColumnExchange::n_columns() const
{
  return own_columns.NumMyElements() + (import ? other_columns->NumMyElements() : 0);
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
  if (!import)
    return x.Values();
  Epetra_Vector others(*other_columns, false);
  others.Import(x, *import, Insert);
  buffer.assign(x.Values(), x.Values() + x.MyLength());
  buffer.insert(buffer.end(), others.Values(), others.Values() + others.MyLength());
  return buffer.data();
}

void ColumnExchange::add_up(const std::vector<double> &sums, Epetra_Vector &y) const
{
  std::copy_n(sums.begin(), y.MyLength(), y.Values());
  if (import) {
    Epetra_Vector others(*other_columns, false);
    std::copy(sums.begin() + y.MyLength(), sums.end(), others.Values());
    y.Export(others, *import, Add);
  }
}

} // namespace dovetail
