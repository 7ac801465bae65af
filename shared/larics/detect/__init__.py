"""The detector: edges, votes for centres, scales, tracker, statistics; the published method."""
