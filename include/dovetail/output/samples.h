// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A solution at many points, in a file, for other runs to be compared with.

#pragma once

#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// What a file of samples holds. The file begins with this as one line of JSON; then come numbers of 8 bytes,
/// part after part and point after point: X (dim), weight, then per component of a domain its value and
/// gradient (1 + dim), of an interface the numerical flux into the source (1). Points of domains are those of
/// Gauss rules with degree + 1 points per direction, those of interfaces are the pairing's (X of the source).
struct Samples
{
  struct Part
  {
    std::string name;
    std::string source, destination;                          ///< of an interface: side_in_words()
    std::vector<std::pair<std::string, unsigned int>> fields; ///< and their numbers of components
    unsigned long n_points = 0;
    unsigned int n_numbers = 0;      ///< per point
    unsigned long long position = 0; ///< of the first number in the file, in bytes
  };
  std::vector<Part> domains, interfaces;

  static const Part *find(const std::vector<Part> &parts, const std::string &name);
};

/// "left : 1", to know a side again in another run.
template <int dim>
std::string side_in_words(const InterfaceSide<dim> &side);

/// Collective; @p solution is ghosted. @throw UserError or OutputError if the file cannot be written.
template <int dim>
void write_samples(const Model<dim> &model, const Vector &solution, double t, const std::string &file);

/// Why samples should not be written to @p file, before anything is computed: a sentence, or empty.
/// Collective.
std::string obstacle_to_samples(const std::string &file, const std::string &reference,
                                const MPI_Comm &communicator);

/// Rank 0 reads the first line. Collective. @throw UserError, complete after "… FILE", on all ranks alike if
/// this is no whole file of samples in @p dim dimensions.
Samples read_samples(const std::string &file, unsigned int dim, const MPI_Comm &communicator);

/// The numbers of the points [begin, end) of a part.
std::vector<double> read_points(const std::string &file, const Samples::Part &part, unsigned long begin,
                                unsigned long end);

} // namespace dovetail
