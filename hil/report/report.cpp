#include "hil/report/report.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "hil/evaluate/rotation.hpp"
#include "hil/io/image.hpp"
#include "hil/report/base64.hpp"
#include "hil/report/page.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

using Json = nlohmann::ordered_json;
constexpr double deg = degrees_per_radian;

// Numbers to seven digits: enough for a plot, and a third of the size. Not a number becomes null.
Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  const auto rounded = parse_double(format_text("%.7g", value));
  return rounded ? Json(*rounded) : Json(nullptr);
}

// A column of the plots: one value a frame.
template <typename ValueOf>
Json column(const RunHistory& history, ValueOf value_of) {
  Json values = Json::array();
  for (const FrameRecord& r : history.frames) values.push_back(number(value_of(r)));
  return values;
}

constexpr double none = std::numeric_limits<double>::quiet_NaN();

template <typename VectorOf>
Json axes(const RunHistory& history, VectorOf vector_of) {
  Json result = Json::array();
  for (int axis = 0; axis < 3; ++axis) {
    result.push_back(column(history, [&](const FrameRecord& r) { return r.has_pose ? vector_of(r)(axis) : none; }));
  }
  return result;
}

Vec3 sigma(const Mat6& P, int first) { return P.diagonal().segment<3>(first).cwiseMax(0.0).cwiseSqrt(); }

Time start_of(const RunHistory& history) { return history.frames.empty() ? Time{} : history.frames.front().time; }

Json estimate_json(const RunHistory& history, double scale) {
  Json json;
  const FrameRecord* first = nullptr;
  for (const FrameRecord& r : history.frames) {
    if (r.has_pose && first == nullptr) first = &r;
  }
  const Time start = start_of(history);
  json["t"] = column(history, [&](const FrameRecord& r) { return (r.time - start).seconds(); });
  json["attitude"] = axes(history, [&](const FrameRecord& r) {
    return Vec3(rotation_vector(r.state.R_CT * first->state.R_CT.transpose()) * deg);
  });
  json["attitude_3sigma"] =
      axes(history, [&](const FrameRecord& r) { return Vec3(sigma(r.state.pose_covariance, 3) * 3.0 * deg); });
  json["rate"] = axes(history, [&](const FrameRecord& r) { return Vec3(r.state.omega_C * deg); });
  json["rate_3sigma"] =
      axes(history, [&](const FrameRecord& r) { return Vec3(sigma(r.state.rate_covariance, 3) * 3.0 * deg); });
  json["position"] = axes(history, [&](const FrameRecord& r) { return Vec3(scale * r.state.t_CT); });
  json["position_3sigma"] =
      axes(history, [&](const FrameRecord& r) { return Vec3(scale * 3.0 * sigma(r.state.pose_covariance, 0)); });
  json["features"] = column(history, [](const FrameRecord& r) { return static_cast<double>(r.features); });
  json["matched"] = column(history, [](const FrameRecord& r) { return static_cast<double>(r.matched); });
  json["inliers"] = column(history, [](const FrameRecord& r) { return static_cast<double>(r.inliers); });
  json["test_ratio"] = column(history, [](const FrameRecord& r) { return r.test_ratio; });
  json["mode"] = column(history, [](const FrameRecord& r) { return static_cast<double>(r.mode); });
  Json stages;
  const std::pair<const char*, std::int64_t app::StageTimes::*> members[] = {
      {"acquire", &app::StageTimes::acquire_ns}, {"predict", &app::StageTimes::predict_ns},
      {"match", &app::StageTimes::match_ns},     {"update", &app::StageTimes::update_ns},
      {"detect", &app::StageTimes::detect_ns},   {"telemetry", &app::StageTimes::telemetry_ns},
      {"total", &app::StageTimes::total_ns}};
  for (const auto& [name, member] : members) {
    stages[name] =
        column(history, [m = member](const FrameRecord& r) { return static_cast<double>(r.times.*m) * 1e-6; });
  }
  json["stage_ms"] = stages;
  return json;
}

// What the truth says at the frames, in the frame and scale the estimate is shown in.
Json truth_json(const RunHistory& history, const Evaluation& evaluation, const Trajectory& truth) {
  std::map<std::int64_t, const TimedPose*> pose_at;
  std::map<std::int64_t, const EpochError*> error_at;
  std::map<std::int64_t, const EpochRate*> rate_at;
  for (const auto& pair : evaluation.association.pairs) pose_at[truth[pair.truth].time.ns] = &truth[pair.truth];
  for (const EpochError& e : evaluation.epochs) error_at[e.time.ns] = &e;
  for (const EpochRate& r : evaluation.rates) rate_at[r.time.ns] = &r;
  const auto find = [&](const auto& map, const FrameRecord& r) -> decltype(map.begin()->second) {
    const auto at = map.lower_bound(r.time.ns - evaluation.association.tolerance.ns);
    return at != map.end() && at->first <= r.time.ns + evaluation.association.tolerance.ns ? at->second : nullptr;
  };
  const Mat3 first = truth[evaluation.association.pairs.front().truth].R_CT;
  const Vec3 nothing = Vec3::Constant(none);
  // A known target frame has no point to be fitted.
  const Vec3 b_T = evaluation.body_point ? evaluation.body_point->b_T : Vec3(Vec3::Zero());
  Json json;
  json["attitude"] = axes(history, [&](const FrameRecord& r) {
    const TimedPose* p = find(pose_at, r);
    return p != nullptr ? Vec3(rotation_vector(p->R_CT * first.transpose()) * deg) : nothing;
  });
  json["attitude_error"] = axes(history, [&](const FrameRecord& r) {
    const EpochError* e = find(error_at, r);
    return e != nullptr ? Vec3(e->attitude * deg) : nothing;
  });
  json["rate"] = axes(history, [&](const FrameRecord& r) {
    const EpochRate* e = find(rate_at, r);
    return e != nullptr ? Vec3(e->truth_omega_C * deg) : nothing;
  });
  json["position"] = axes(history, [&](const FrameRecord& r) {
    const TimedPose* p = find(pose_at, r);
    return p != nullptr ? Vec3(p->t_CT + p->R_CT * b_T) : nothing;
  });
  json["nees"] = column(history, [&](const FrameRecord& r) {
    const EpochError* e = find(error_at, r);
    return e != nullptr && e->nees ? *e->nees : none;
  });
  if (evaluation.nees) json["nees_band"] = {number(evaluation.nees->epoch_low), number(evaluation.nees->epoch_high)};
  json["position_error"] = axes(history, [&](const FrameRecord& r) {
    const EpochError* e = find(error_at, r);
    return e != nullptr ? e->position : nothing;
  });
  return json;
}

// An image that went through the run; one that can no longer be read is left out.
Json snapshots_json(const RunHistory& history) {
  const Time start = start_of(history);
  Json list = Json::array();
  for (const Snapshot& s : history.snapshots) {
    Json json;
    try {
      Image image = load_image(s.image);
      keep_upper_bytes(image);
      json["width"] = image.width_px;
      json["height"] = image.height_px;
      json["png"] = base64(encode_png(image));
    } catch (const std::exception&) {
      continue;
    }
    json["frame"] = s.frame;
    json["t"] = number((s.time - start).seconds());
    json["mode"] = app::to_string(s.mode);
    json["features"] = Json::array();
    for (const app::FeatureReport& f : s.features) {
      // use, predicted, measured, Euclidean
      json["features"].push_back({static_cast<int>(f.use), number(f.predicted_px.x()), number(f.predicted_px.y()),
                                  number(f.measured_px.x()), number(f.measured_px.y()), f.euclidean ? 1 : 0, f.index});
    }
    list.push_back(json);
  }
  return list;
}

Json events_json(const RunHistory& history) {
  const Time start = start_of(history);
  Json list = Json::array();
  for (const EventNote& event : history.events) list.push_back({number((event.time - start).seconds()), event.text});
  return list;
}

Json figures_json(const std::vector<ReportFigure>& figures) {
  const auto or_none = [](double value) { return value < 0.0 ? Json(nullptr) : number(value); };
  Json list = Json::array();
  for (const ReportFigure& f : figures)
    list.push_back({f.name, number(f.reached), or_none(f.paper), or_none(f.must), or_none(f.goal)});
  return list;
}

}  // namespace

std::string report_html(const RunDescription& description, const ReplayOutcome& outcome, const RunHistory& history,
                        const Evaluation* evaluation, const Trajectory* truth,
                        const std::vector<ReportFigure>& figures) {
  const bool judged = evaluation != nullptr && truth != nullptr;
  const double scale = judged && evaluation->body_point ? evaluation->body_point->scale : 1.0;
  Json data;
  data["summary"] = Json::parse(summary_json(description, outcome, history, evaluation));
  data["scale"] = scale;
  data["fitted"] = judged && evaluation->body_point.has_value();
  data["estimate"] = estimate_json(history, scale);
  data["truth"] = judged ? truth_json(history, *evaluation, *truth) : Json(nullptr);
  data["snapshots"] = snapshots_json(history);
  data["events"] = events_json(history);
  data["figures"] = figures_json(figures);
  return page_html("relnav: " + description.dataset, data.dump(), PageKind::run);
}

}  // namespace relnav::hil
