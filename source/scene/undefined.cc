// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>

#include <boost/serialization/utility.hpp>

#include <cmath>
#include <sstream>

namespace dovetail {

Undefined &last_undefined()
{
  static Undefined last;
  return last;
}

bool undefined(const std::string &reason, const bool is_at_every_state)
{
  last_undefined() = {reason, is_at_every_state};
  return false;
}

std::string sentence_about(const Section &section, const std::string &entry, const std::string &message)
{
  try {
    section.fail(entry, message);
  } catch (const UserError &error) {
    return error.what();
  }
}

std::string in_words(const double number, const unsigned int n_digits)
{
  std::ostringstream words;
  words.precision(n_digits);
  words << number;
  return words.str();
}

template <int dim>
std::string in_words(const dealii::Point<dim> &X, const unsigned int n_digits)
{
  std::string words;
  for (unsigned int d = 0; d < dim; ++d)
    words += (d > 0 ? ", " : "(") + in_words(X[d], n_digits);
  return words + ")";
}

template <int dim>
double finite(const double value, const Section &section, const std::string &entry,
              const dealii::Point<dim> &X, const double t)
{
  if (!std::isfinite(value))
    undefined(sentence_about(section, entry,
                             std::string("is ") + (std::isnan(value) ? "not a number" : "infinite") + " at " +
                                 in_words(X) + " and t = " + in_words(t) + ", but must be a finite number."),
              true);
  return value;
}

Undefined first_of_ranks(const Undefined &own, const MPI_Comm &communicator)
{
  for (const auto &[reason, is_at_every_state] :
       dealii::Utilities::MPI::all_gather(communicator, std::make_pair(own.reason, own.is_at_every_state)))
    if (!reason.empty())
      return {reason, is_at_every_state};
  return {};
}

void refuse_undefined(const Undefined &own, const MPI_Comm &communicator)
{
  if (dealii::Utilities::MPI::max(own ? 1 : 0, communicator) == 1)
    throw UserError(first_of_ranks(own, communicator).reason);
}

void throw_on_all_ranks(const std::exception_ptr &caught, const MPI_Comm &communicator)
{
  if (dealii::Utilities::MPI::max(caught ? 1 : 0, communicator) == 0)
    return;
  if (caught)
    std::rethrow_exception(caught);
  throw std::runtime_error("another rank could not assemble its part.");
}

template std::string in_words(const dealii::Point<2> &, unsigned int);
template std::string in_words(const dealii::Point<3> &, unsigned int);
template double finite(double, const Section &, const std::string &, const dealii::Point<2> &, double);
template double finite(double, const Section &, const std::string &, const dealii::Point<3> &, double);

} // namespace dovetail
