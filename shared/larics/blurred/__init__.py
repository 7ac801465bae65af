"""The blur-model reader: reads a candidate by a model of the blurred marker (setting `second_opinion`)."""
