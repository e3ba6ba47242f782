// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/partners.h>

#include <utility>

namespace dovetail {

Partners find_who_asks(const Partners &asked, const MPI_Comm &communicator)
{
  std::map<unsigned int, std::vector<std::pair<unsigned int, unsigned int>>> numbers;
  for (const auto &[rank, places] : asked)
    for (const SharedNumber &place : places)
      numbers[rank].emplace_back(place.array, place.index);
  Partners result;
  for (const auto &[rank, places] : dealii::Utilities::MPI::some_to_some(communicator, numbers))
    for (const auto &[array, index] : places)
      result[rank].push_back({array, index});
  return result;
}

} // namespace dovetail
