// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Between dim dimensions and the three of the laws.

#pragma once

#include <dovetail/material/term.h>

namespace dovetail {

template <int dim>
dealii::Tensor<1, 3> embed(const dealii::Tensor<1, dim> &vector)
{
  dealii::Tensor<1, 3> result;
  for (unsigned int i = 0; i < dim; ++i)
    result[i] = vector[i];
  return result;
}

template <int dim>
dealii::Point<3> embed(const dealii::Point<dim> &point)
{
  return dealii::Point<3>(embed(static_cast<const dealii::Tensor<1, dim> &>(point)));
}

template <int dim>
dealii::Tensor<1, dim> restrict_to(const dealii::Tensor<1, 3> &vector)
{
  dealii::Tensor<1, dim> result;
  for (unsigned int i = 0; i < dim; ++i)
    result[i] = vector[i];
  return result;
}

template <int dim>
dealii::Tensor<2, dim> restrict_to(const dealii::Tensor<2, 3> &tensor)
{
  dealii::Tensor<2, dim> result;
  for (unsigned int i = 0; i < dim; ++i)
    result[i] = restrict_to<dim>(tensor[i]);
  return result;
}

} // namespace dovetail
