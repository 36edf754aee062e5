"""Controller and learner over Zenoh, with the interfaces of the local ones."""
