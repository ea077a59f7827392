#include <Eigen/Cholesky>

#include "fitting/bake/body_shapes.h"
#include "fitting/body/body_measures.h"

namespace cheval::fitting::bake {
namespace {

constexpr auto kMeasured = static_cast<Eigen::Index>(kMeasuredParameterCount);
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// How far a woman's breasts stand out beyond the mannequin's and a man's chest lies behind it, and how both vary,
/// metres. No survey measures it; it is told apart from chest depth only in part.
constexpr double kBustOfWomen = 0.014;
constexpr double kBustOfMen = -0.014;
constexpr double kBustVaries = 0.012;
/// How much builds of one sex vary in what is masculine.
constexpr double kBuildVaries = 0.6;

/// Of the chest's section, metres; chests are between an oval and the mannequin's.
constexpr double kSquareness = 0.000;
constexpr double kSquarenessVaries = 0.0015;

/// How much the girths halfway between chest, waist and hips vary by themselves, metres.
constexpr double kBetweenVaries = 0.012;

}  // namespace

Expected<void> setPeople(Body& body, const People& women, const People& men) {
    for (const People* people : {&women, &men}) {
        const bool sound = people->mean.size() == kMeasured && people->covariance.rows() == kMeasured &&
                           people->covariance.cols() == kMeasured && people->mean.allFinite() &&
                           people->covariance.allFinite() &&
                           Eigen::LLT<Matrix>(people->covariance).info() == Eigen::Success;
        if (sound) continue;
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "what bodies are like has not 14 dimensions, or its correlations contradict each other",
                     .mend = "correct the table of people",
                     .why = "the fitted body leans on it"};
    }
    const Vector mean = 0.5 * (women.mean + men.mean);
    constexpr auto kAll = static_cast<Eigen::Index>(kShapeParameterCount);
    Matrix covariance = Matrix::Zero(kAll, kAll);
    covariance.topLeftCorner(kMeasured, kMeasured) = 0.5 * (women.covariance + men.covariance);
    // What lies between women and men, in all parameters at once.
    Vector between(kAll);
    between.head(kMeasured) = 0.5 * (men.mean - women.mean);
    const auto bust = static_cast<Eigen::Index>(index(ShapeParameter::bust));
    const auto masculine = static_cast<Eigen::Index>(index(ShapeParameter::masculine));
    between[bust] = 0.5 * (kBustOfMen - kBustOfWomen);
    between[masculine] = 1.0;
    covariance += between * between.transpose();
    covariance(bust, bust) += kBustVaries * kBustVaries;
    covariance(masculine, masculine) += kBuildVaries * kBuildVaries;
    const auto square = static_cast<Eigen::Index>(index(ShapeParameter::chestSquareness));
    covariance(square, square) = kSquarenessVaries * kSquarenessVaries;
    for (const ShapeParameter alone : {ShapeParameter::ribs, ShapeParameter::flanks}) {
        const auto i = static_cast<Eigen::Index>(index(alone));
        covariance(i, i) = kBetweenVaries * kBetweenVaries;
    }

    const BodyMeasures measures(body);
    const MeasuredParameters mannequin = measures.measure(body.mesh.positions, body.joints);
    body.shapes.mean.setZero();
    body.shapes.mean.head(kMeasured) = (mean - mannequin.cast<double>()).cast<float>();
    body.shapes.mean[square] = static_cast<float>(kSquareness);
    body.shapes.mean[bust] = static_cast<float>(0.5 * (kBustOfMen + kBustOfWomen));
    body.shapes.covariance = covariance.cast<float>();
    return {};
}

}  // namespace cheval::fitting::bake
