"""The parts of random_campaign.py: cpp_tokens -> changes -> syntax (what is a mutant), build_tree -> trial (what it does)."""
