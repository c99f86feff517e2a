//! Dense linear algebra that knows no robot: least squares, rank decisions, singular values.
