// How the mannequin changes with its parameters: displacement fields over its surface, combined so that each parameter
// changes its own dimension and no other (ShapeParameter).
#pragma once

#include <Eigen/Core>

#include "fitting/bake/body_builder.h"
#include "fitting/body/body.h"
#include "hal/expected.h"

namespace cheval::fitting::bake {

/// Fills model.body.shapes but for mean and covariance. The same bytes every time.
void makeBodyShapes(BodyModel& model);

/// What bodies of one sex are like: mean and covariance of the first fourteen parameters' dimensions, metres.
struct People {
    Eigen::VectorXd mean;
    Eigen::MatrixXd covariance;
};

/// Sets mean and covariance of body.shapes to those of women and men together, as many of one as of the other.
/// `masculine` is −1 and +1 with them, `bust` follows it; the rest vary by themselves.
/// Errors: invalidInput, when there are not fourteen dimensions or a covariance is not positive definite.
Expected<void> setPeople(Body& body, const People& women, const People& men);

}  // namespace cheval::fitting::bake
