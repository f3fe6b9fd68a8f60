#include "service/tracker/tracker.h"

#include "service/tracker/stages/publish.h"

namespace omni::tracker {

void Update(const Config& config, const base::HallScan& scan, State& state, base::ToolState& tool,
            bool pushed) noexcept {
  if (!IsRepeated(config, scan, state.room)) {
    const Received received = Receive(config, scan, state.room);
    Predicted predicted = PredictTo(config, received, pushed, state);
    Explanation explanation = Explain(config, received, predicted, state);
    const Observation observation{config, received, predicted, explanation};
    if (!Learn(observation, state)) explanation.outcome.good = false;
    Publish(observation, predicted.filter, state);
  } else {
    PublishRepeated(config, scan, state);
  }
  tool = state.pose.published;
}

}  // namespace omni::tracker
